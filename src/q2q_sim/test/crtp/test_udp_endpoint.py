"""The UDP endpoint: floods, dead and many clients, a link that delays, ports that are taken."""

import socket
import struct
from collections.abc import Iterator
from contextlib import suppress

import numpy as np
import pytest
from open_ports import addresses_of

from cflib_fleet import CflibFleet
from q2q_sim.crtp.udp_endpoint import CrtpEndpoint
from q2q_sim.link.shared_radios import SharedRadioParams
from q2q_sim.plant.body.state_row import ROTOR_MAX1

VERSION = b"\xdd\x00"
TIMEOUT_S = 0.5
"""An answer that has not come by then was dropped [s]."""
TRIES = 40


@pytest.fixture
def crazyflies() -> CflibFleet:
    made = CflibFleet(np.array([[0.0, 0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]]))
    made.fly(0.5)
    return made


@pytest.fixture
def endpoint(crazyflies: CflibFleet) -> Iterator[CrtpEndpoint]:
    with CrtpEndpoint(crazyflies.fleet, 0, SharedRadioParams()) as opened:
        yield opened


def client_of(endpoint: CrtpEndpoint, vehicle: int = 0) -> socket.socket:
    made = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    made.settimeout(TIMEOUT_S)
    made.connect(("127.0.0.1", int(endpoint.uris[vehicle].rpartition(":")[2])))
    return made


def answer(client: socket.socket, datagram: bytes) -> bytes:
    """Return the answer on the same port; a full socket may drop a datagram, so it is asked again."""
    for _ in range(TRIES):
        client.send(datagram)
        try:
            got = client.recv(64)
            while got[0] & 0xF3 != datagram[0] & 0xF3:
                got = client.recv(64)
        except TimeoutError:
            continue
        return got
    raise AssertionError(f"no answer to {datagram!r} after {TRIES} tries")


def test_a_probe_is_answered_at_every_vehicles_port(endpoint: CrtpEndpoint) -> None:
    for vehicle in (0, 1):
        with client_of(endpoint, vehicle) as client:
            assert answer(client, b"\xff") == b"\xff"


def test_ten_thousand_datagrams_of_garbage_starve_neither_the_room_nor_a_sound_client(
    endpoint: CrtpEndpoint, crazyflies: CflibFleet
) -> None:
    rng = np.random.default_rng(0)
    garbage = [rng.bytes(int(size)) for size in rng.integers(0, 200, 500)]
    with client_of(endpoint) as noisy, client_of(endpoint) as sound:
        for number in range(10_000):
            noisy.send(garbage[number % len(garbage)])
            if number % 100 == 0:
                endpoint.fly(crazyflies.drive)
        assert answer(sound, VERSION) == VERSION + struct.pack("<I", 12)
    assert np.isfinite(crazyflies.swarm.state[:, :ROTOR_MAX1]).all()
    assert crazyflies.fleet.vehicles[0].refusals.count > 0
    assert crazyflies.fleet.vehicles[1].refusals.count == 0


def test_logs_reach_their_client_and_a_client_that_is_gone_disturbs_nobody(
    endpoint: CrtpEndpoint, crazyflies: CflibFleet
) -> None:
    gone, alive = client_of(endpoint), client_of(endpoint)
    for client in (gone, alive):
        assert answer(client, b"\x5d\x06\x01\x07\x00\x00")[-1] == 0
        assert answer(client, b"\x5d\x03\x01\x01")[-1] == 0
    gone.close()
    for _ in range(50):
        endpoint.fly(crazyflies.drive)
    stamps = []
    while len(stamps) < 50:
        got = alive.recv(64)
        if got[0] == 0x5E:
            stamps.append(int.from_bytes(got[2:5], "little"))
    alive.close()
    assert np.diff(stamps).tolist() == [10] * 49


def test_a_delayed_link_answers_late_but_answers(crazyflies: CflibFleet) -> None:
    now = [0.0]
    link = SharedRadioParams(latency=0.05)
    opened = CrtpEndpoint(crazyflies.fleet, 0, link, now=lambda: now[0])
    with opened as endpoint, client_of(endpoint) as client:
        client.send(VERSION)
        while endpoint.traffic.received == 0:
            endpoint.fly(crazyflies.drive)
        assert endpoint.traffic.sent == 0
        now[0] = 0.06  # the request has arrived, its answer is under way
        endpoint.fly(crazyflies.drive)
        now[0] = 0.12
        while endpoint.traffic.sent == 0:
            endpoint.fly(crazyflies.drive)
        assert client.recv(64)[:1] in {b"\xdd", b"\x0c"}


def _below_a_free_port() -> socket.socket:
    """Return a socket on a port whose predecessor is free."""
    while True:
        probe = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        probe.bind(("127.0.0.1", 0))
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as before, suppress(OSError):
            before.bind(("127.0.0.1", probe.getsockname()[1] - 1))
            return probe
        probe.close()


def test_a_taken_port_closes_what_was_opened_and_says_so(crazyflies: CflibFleet) -> None:
    with _below_a_free_port() as probe:
        second = probe.getsockname()[1]
        with pytest.raises(OSError, match=f"UDP port {second} of cf2 is taken on 127.0.0.1"):
            CrtpEndpoint(crazyflies.fleet, second - 1, SharedRadioParams())
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as again:
            again.bind(("127.0.0.1", second - 1))


def test_ports_that_do_not_exist_are_refused_with_those_that_do(crazyflies: CflibFleet) -> None:
    last = 65536 - len(crazyflies.swarm.names)
    with pytest.raises(ValueError, match=rf"must be in \[0, {last}\] for"):
        CrtpEndpoint(crazyflies.fleet, last + 1, SharedRadioParams())


def test_ports_are_open_on_loopback_only(endpoint: CrtpEndpoint) -> None:
    for uri in endpoint.uris:
        address, _, port = uri.removeprefix("udp://").partition(":")
        assert addresses_of("udp", int(port)) == {address} == {"127.0.0.1"}
        assert addresses_of("udp6", int(port)) == set()
