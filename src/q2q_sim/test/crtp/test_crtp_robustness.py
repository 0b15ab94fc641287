"""Garbage, floods, many clients, reboots: no crash, no stuck vehicle, a clear word."""

import struct

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cflib_fleet import CflibFleet
from q2q_sim.crtp.client_warnings import ClientWarnings
from q2q_sim.crtp.packets.packet import MAX_DATA, MalformedError, Packet, datagram_of, is_stream, packet_of
from q2q_sim.crtp.vehicle import MOST_CLIENTS
from q2q_sim.firmware.parameters.parameter_table import TABLE
from q2q_sim.firmware.supervisor.rules import State
from q2q_sim.link.shared_radios import DelayLine, SharedRadioParams, SharedRadios
from q2q_sim.plant.body.state_row import ROTOR_MAX1

PORTS = st.sampled_from([0, 2, 3, 4, 5, 6, 7, 8, 9, 13, 15])
ANY = st.one_of(
    st.binary(max_size=64),
    st.builds(lambda port, channel, data: bytes([port << 4 | 12 | channel]) + data, PORTS,
              st.integers(0, 3), st.binary(max_size=MAX_DATA)),
)  # fmt: skip


@given(st.integers(0, 15), st.integers(0, 3), st.binary(max_size=MAX_DATA))
def test_packets_survive_the_wire(port: int, channel: int, data: bytes) -> None:
    assert packet_of(datagram_of(Packet(port, channel, data))) == Packet(port, channel, data)


@pytest.mark.parametrize("size", [0, 32, 64])
def test_datagrams_of_no_packets_size_are_refused(size: int) -> None:
    with pytest.raises(MalformedError, match="1 to 31"):
        packet_of(bytes(size))


@settings(
    deadline=None,
    max_examples=100,
)
@given(st.lists(ANY, max_size=30))
def test_no_datagram_crashes_a_vehicle_or_makes_its_answers_too_long(datagrams: list[bytes]) -> None:
    crazyflies = CflibFleet(np.zeros((1, 4)))
    crazyflies.fly(0.3)
    for number, datagram in enumerate(datagrams):
        for answer in crazyflies.fleet.vehicles[0].handle(datagram, client=number % 3):
            assert 1 <= len(answer) <= 1 + MAX_DATA
    crazyflies.fly(0.1)
    assert np.isfinite(crazyflies.swarm.state[:, :ROTOR_MAX1]).all()
    assert all(1 <= len(one.datagram) <= 1 + MAX_DATA for one in crazyflies.out)
    # a sound client still gets its answer
    assert crazyflies.fleet.vehicles[0].handle(b"\xdd\x00") == [b"\xdd\x00" + struct.pack("<I", 12)]


def test_senseless_setpoints_are_refused_with_a_word_and_the_old_one_stays(grounded: CflibFleet) -> None:
    vehicle = grounded.fleet.vehicles[0]
    vehicle.handle(b"\x7c\x07" + struct.pack("<ffff", 0.0, 0.0, 1.0, 0.0))
    before = vehicle.firmware.commander.setpoint
    for bad in (
        b"\x7c\x07" + struct.pack("<ffff", float("nan"), 0.0, 1.0, 0.0),
        b"\x7c\x07" + struct.pack("<fff", 0.0, 0.0, 1.0),
        b"\x7c\x03" + bytes(16),
        b"\x3c" + struct.pack("<fff", 0.0, 0.0, 0.0),
        b"\x6c" + struct.pack("<fff", float("inf"), 0.0, 0.0),
        b"\xac\x00",
    ):
        assert vehicle.handle(bad) == []
    assert vehicle.firmware.commander.setpoint == before
    assert vehicle.refusals.count == 6
    assert "not served" in vehicle.refusals.last


def test_a_probe_is_answered_and_makes_no_client(grounded: CflibFleet) -> None:
    vehicle = grounded.fleet.vehicles[0]
    grounded.fly(1.5)
    assert vehicle.handle(b"\xff", client="probe") == [b"\xff"]
    assert vehicle.clients == ()


def test_two_clients_have_their_own_logs_and_are_reported_each_other(grounded: CflibFleet) -> None:
    vehicle = grounded.fleet.vehicles[0]
    for client in ("one", "two"):
        vehicle.handle(b"\x5d\x05", client)
        vehicle.handle(b"\x5d\x06\x01\x07\x00\x00", client)
        vehicle.handle(b"\x5d\x03\x01\x01", client)
    vehicle.handle(b"\x5d\x05", "two")  # resets its own blocks only
    grounded.out.clear()
    grounded.fly(0.1)
    assert {one.client for one in grounded.out if one.datagram[0] == 0x5E} == {"one"}
    words = {client: b"".join(one.datagram[1:] for one in grounded.out
                              if one.client == client and one.datagram[0] == 0x0C)
             for client in ("one", "two")}  # fmt: skip
    assert b"2 clients; all may command" in words["one"]
    assert b"2 clients; all may command" in words["two"]


def test_a_silent_client_is_forgotten_and_many_clients_do_not_pile_up(grounded: CflibFleet) -> None:
    vehicle = grounded.fleet.vehicles[0]
    for client in range(100):
        vehicle.handle(b"\xfc", client)
    assert vehicle.clients == tuple(range(100))[-MOST_CLIENTS:]
    assert "the client silent for longest gets nothing more" in vehicle.firmware.console
    grounded.fly(1.2)
    assert vehicle.clients == ()


def test_what_vehicles_refuse_is_reported_with_its_count_and_cause_until_they_refuse_no_more() -> None:
    crazyflies = CflibFleet(np.array([[0.0, 0.0, 0.0, 0.0], [2.0, 0.0, 0.0, 0.0]]))
    one, other = crazyflies.fleet.vehicles
    warnings = ClientWarnings(crazyflies.fleet.vehicles)
    assert warnings.poll() == ""
    for bad in (b"\x7c\x03" + bytes(16), b"\xac\x00"):
        one.handle(bad)
    for client in range(MOST_CLIENTS + 3):
        other.handle(b"\xfc", client)
    refused = f"CRTP of {one.name}: packets refused: 2 (port 10: not served)"
    displaced = f"CRTP of {other.name}: clients displaced: 3 (at most 8: stop the others)"
    assert warnings.poll() == f"{refused}; {displaced}"
    one.handle(b"\xfc")
    assert warnings.poll() == ""
    one.handle(b"\xac\x00")
    assert warnings.poll() == refused.replace("2", "1")
    assert other.refusals.count == 0  # its packets were taken


def test_the_radios_commands_turn_a_locked_vehicle_off_and_start_it_anew(grounded: CflibFleet) -> None:
    vehicle = grounded.fleet.vehicles[0]
    vehicle.handle(b"\x9d\x03")
    grounded.fly(0.2)
    assert vehicle.firmware.supervisor.state == State.LOCKED
    assert vehicle.handle(b"\xfc\x00") == [b"\xfc\x00"]
    assert vehicle.handle(b"\xff\xfe\x02") == [b"\xff"]
    assert vehicle.handle(b"\xfc\x00") == []  # it is off
    vehicle.handle(b"\xff\xfe\x03")
    assert vehicle.handle(b"\xfc\x00") == [b"\xfc\x00"]
    grounded.fly(0.4)
    assert vehicle.firmware.supervisor.state == State.READY_TO_FLY


def test_a_radio_sends_one_packet_at_a_time_for_all_its_vehicles() -> None:
    radios = SharedRadios(SharedRadioParams(latency=0.005, rate=1000.0, per_radio=2), vehicles=4, seed=0)
    times = [radios.arrival(row, 1.0, streamed=True) for row in (0, 1, 0, 2)]
    np.testing.assert_allclose(times, [1.006, 1.007, 1.008, 1.006])


def test_a_packet_that_would_wait_too_long_is_dropped() -> None:
    radios = SharedRadios(SharedRadioParams(rate=100.0, patience=0.05), vehicles=1, seed=0)
    arrived = [radios.arrival(0, 0.0, streamed=True) for _ in range(10)]
    assert [one is not None for one in arrived] == [True] * 6 + [False] * 4


def test_losses_end_streams_and_delay_answers() -> None:
    radios = SharedRadios(SharedRadioParams(latency=0.01, loss=0.3), vehicles=1, seed=1)
    streamed = [radios.arrival(0, 0.0, streamed=True) for _ in range(4000)]
    lost = sum(one is None for one in streamed) / 4000
    assert lost == pytest.approx(0.3, abs=0.03)  # 4 standard deviations
    answers = [radios.arrival(0, 0.0, streamed=False) for _ in range(4000)]
    assert None not in answers
    # geometric: 0.01 s times the mean number of tries, 1 / 0.7
    assert np.mean([one for one in answers if one is not None]) == pytest.approx(0.01 / 0.7, rel=0.03)


def test_streams_are_setpoints_positions_and_log_data() -> None:
    assert [is_stream(bytes([head])) for head in (0x3C, 0x6D, 0x7C, 0x5E)] == [True] * 4
    assert not any(is_stream(bytes([head])) for head in (0x5D, 0x2C, 0x8C, 0x9D, 0xFC))


@given(st.lists(st.floats(0.0, 1.0), max_size=30), st.floats(0.0, 1.0))
def test_a_delay_line_gives_what_has_arrived_in_order_of_arrival(arrivals: list[float], t: float) -> None:
    line: DelayLine[int] = DelayLine()
    for number, arrival in enumerate(arrivals):
        line.push(arrival, number)
    expected = sorted((one, k) for k, one in enumerate(arrivals) if one <= t)
    assert line.due(t) == [k for _, k in expected]
    rest = [one for one in arrivals if one > t]
    assert line.next_arrival == (min(rest) if rest else None)


@pytest.mark.parametrize("number", [float("inf"), float("nan"), 3.4e38])
@pytest.mark.parametrize("start", [(5, 0, 0, 0, 1), (5, 0, 1, 0, 1), (5, 0, 1, 1, 1), (13, 0, 1, 1, 0, 1)])
def test_an_uploaded_trajectory_of_no_numbers_harms_its_own_vehicle_only(
    start: tuple[int, ...], number: float
) -> None:
    """Only fields of packets are checked; what they leave in memory is read as floats."""
    crazyflies = CflibFleet(np.array([[0.0, 0.0, 1.0, 0.0], [2.0, 0.0, 1.0, 0.0]]))
    one, other = crazyflies.fleet.vehicles
    crazyflies.fly(0.3)
    for vehicle in (one, other):
        vehicle.handle(b"\x8c" + struct.pack("<BBffBf", 7, 0, 0.5, 0.0, 1, 1.0))
    crazyflies.fly(1.5)
    piece = struct.pack("<33f", *[number] * 32, 1.0)
    for at in range(0, len(piece), 22):
        one.handle(b"\x4e" + struct.pack("<BI", 0, at) + piece[at : at + 22])
    one.handle(b"\x8c" + struct.pack("<BBBBIB", 6, 1, 1, 0, 0, 1))
    one.handle(b"\x8c" + struct.pack(f"<{len(start)}Bf", *start, 1.0))
    crazyflies.fly(1.5)
    assert np.isfinite(crazyflies.swarm.state[:, :ROTOR_MAX1]).all()
    assert crazyflies.swarm.state[1, 2] == pytest.approx(0.5, abs=0.05)


HUGE = st.sampled_from([3.4e38, -3.4e38, 1e20, 0.0, -1.0])
WRITABLE = [number for number, one in enumerate(TABLE) if one.kind == "float" and not one.read_only]


@settings(deadline=None, max_examples=60)
@given(st.sampled_from(WRITABLE), HUGE, st.sampled_from([7, 8, 9, 10]), HUGE, st.sampled_from([1, 2]))
def test_senseless_gains_and_setpoints_never_make_the_room_no_number(
    parameter: int, gain: float, kind: int, demanded: float, controller: int
) -> None:
    crazyflies = CflibFleet(np.array([[0.0, 0.0, 1.0, 0.0], [0.05, 0.0, 1.5, 0.0]]))
    vehicle = crazyflies.fleet.vehicles[0]
    vehicle.firmware.parameters.set("stabilizer.controller", controller)
    crazyflies.fly(0.4)
    vehicle.handle(b"\x2e" + struct.pack("<Hf", parameter, gain))
    crazyflies.fly(0.4, lambda _: vehicle.handle(b"\x7c" + struct.pack("<Bffff", kind, *[demanded] * 4)))
    assert np.isfinite(crazyflies.swarm.state[:, :ROTOR_MAX1]).all()
