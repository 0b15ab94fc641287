"""Faults strike what, when and whom they say, and nothing else."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from q2q_model.documents.plain_values import from_plain
from q2q_model.geometry.rotations import matrix_from_quat
from q2q_model.model_files.find_model import find_model
from q2q_model.signals.stamps import TICK_NS, TICK_S, time_from_stamp
from q2q_model.signals.values import MocapFrame
from q2q_sim.faults.drawn_faults import LENGTHS, SIZES, random_faults
from q2q_sim.faults.faults import KINDS, Fault
from q2q_sim.faults.injection import FaultInjection
from q2q_sim.loop.closed_loop import FlightOptions, fly
from q2q_sim.loop.room import Room, Tick
from q2q_sim.monitors.policies.exemptions.thrust_exceeded import thrust_left
from q2q_sim.scenarios import library
from q2q_sim.sensors.vicon import Injected

NAMES = ("cf1", "cf2", "cf3")
CALM = replace(library.load("table6"), duration=1.0)


def _ticks(*faults: Fault, count: int = 40) -> list[tuple[Tick, np.ndarray]]:
    room = Room(replace(CALM, faults=faults), seed=0)
    seen = []
    for _ in range(count):
        seen.append((room.capture(), room.injected.copy()))
        room.advance(None)
    return seen


def _truth(count: int = 40) -> list[Tick]:
    room = Room(CALM, seed=0)
    ticks = []
    for _ in range(count):
        ticks.append(room.capture())
        room.advance(None)
    return ticks


@pytest.mark.parametrize(
    ("kind", "size", "mark"),
    [
        ("outlier", 1.5, Injected.OUTLIER),
        ("jump", 1.5, Injected.OUTLIER),
        ("flip", 0.0, Injected.FLIP),
        ("nan", 0.0, Injected.NAN),
        ("dropout", 0.0, Injected.DROPOUT),
    ],
)
def test_a_fault_of_one_vehicle_strikes_its_rows_in_its_time_only(
    kind: str, size: float, mark: Injected
) -> None:
    struck = _ticks(Fault(kind, start=0.1, duration=0.05, vehicles=("cf2",), size=size))
    for k, ((tick, flags), clean) in enumerate(zip(struck, _truth(), strict=True)):
        acting = 10 <= k < 15
        assert flags.tolist() == [0, int(mark) if acting else 0]
        assert tick.frame.names == (("cf1",) if kind == "dropout" and acting else ("cf1", "cf2"))
        np.testing.assert_array_equal(tick.frame.pos[0], clean.frame.pos[0])
        if not acting:
            np.testing.assert_array_equal(tick.frame.pos, clean.frame.pos)
            np.testing.assert_array_equal(tick.frame.quat, clean.frame.quat)
            continue
        if kind in {"outlier", "jump"}:
            assert np.linalg.norm(tick.frame.pos[1] - clean.frame.pos[1]) == pytest.approx(1.5, rel=1e-12)
        if kind == "jump":
            np.testing.assert_array_equal(tick.frame.pos[1], clean.frame.pos[1] + [1.5, 0.0, 0.0])
        if kind == "nan":
            assert np.isnan(tick.frame.pos[1]).all()
        if kind == "flip":
            turn = matrix_from_quat(clean.frame.quat[1]).T @ matrix_from_quat(tick.frame.quat[1])
            np.testing.assert_allclose(turn, np.diag([1.0, -1.0, -1.0]), atol=1e-12)


@pytest.mark.parametrize(("start", "first"), [(0.104, 10), (0.106, 11)])
def test_a_fault_begins_and_ends_at_the_nearest_ticks(start: float, first: int) -> None:
    struck = [flags.any() for _, flags in _ticks(Fault("nan", start, duration=0.05))]
    assert np.flatnonzero(struck).tolist() == list(range(first, first + 5))


def test_a_swap_gives_two_vehicles_each_others_name() -> None:
    tick, flags = _ticks(Fault("swap", 0.1, 0.05, ("cf1", "cf2")))[12]
    clean = _truth()[12]
    assert tick.frame.names == ("cf2", "cf1")
    np.testing.assert_array_equal(tick.frame.pos, clean.frame.pos)
    assert (flags == int(Injected.SWAP)).all()


@pytest.mark.parametrize(
    ("fault", "stamps"),
    [
        (Fault("repeated", 0.10, 0.03), [8, 9, 9, 9, 9, 13, 14]),
        (Fault("late", 0.10, 0.05, size=0.02), [8, 9, 9, 9, 10, 11, 12, 15]),
        (Fault("reordered", 0.10, 0.05), [8, 9, 8, 11, 10, 13, 12, 15]),
        (Fault("clock_jump", 0.10, 0.03, size=-0.05), [8, 9, 5, 6, 7, 13, 14]),
        (Fault("stale", 0.10, 0.03), [8, 9, 10, 11, 12, 13, 14]),
    ],
    ids=lambda value: value.kind if isinstance(value, Fault) else "",
)
def test_frames_come_under_the_stamps_of_their_fault(fault: Fault, stamps: list[int]) -> None:
    seen = _ticks(fault)[8 : 8 + len(stamps)]
    assert [tick.frame_stamp_ns // 10_000_000 for tick, _ in seen] == stamps
    assert [tick.frame.t for tick, _ in seen] == [tick.frame_stamp_ns * 1e-9 for tick, _ in seen]
    assert [tick.stamp_ns // 10_000_000 for tick, _ in seen] == list(range(8, 8 + len(stamps)))
    clean = _truth()
    showing = [9] * 3 if fault.kind == "stale" else stamps[2:5]
    if fault.kind != "clock_jump":
        for (tick, _), k in zip(seen[2:5], showing, strict=True):
            np.testing.assert_array_equal(tick.frame.pos, clean[k].frame.pos)


@pytest.mark.parametrize(("start", "showing"), [(0.0, [0, 0, 0, 3, 4, 5]), (0.02, [0, 1, 1, 1, 1, 5])])
def test_stale_frames_show_the_last_one_before_them_or_the_first(start: float, showing: list[int]) -> None:
    injection = FaultInjection([Fault("stale", start, 0.03)], ("cf1",), 10_000_000, seed=0)
    level = np.array([[0.0, 0.0, 0.0, 1.0]])
    for k, shown in enumerate(showing):
        frame = MocapFrame(0.01 * k, ("cf1",), np.array([[float(k), 0.0, 1.0]]), level)
        delivery = injection.deliver(frame, 10_000_000 * k, np.zeros(1, np.uint8))
        assert (delivery.frame.pos[0, 0], delivery.stamp_ns) == (shown, 10_000_000 * k)


@pytest.mark.parametrize(
    ("fault", "stamps"),
    [
        (Fault("repeated", 0.12, 0.03), [9, 5, 6, 6, 6, 6, 10, 11, 12, 18]),
        (Fault("late", 0.12, 0.06, size=0.02), [9, 5, 6, 6, 6, 7, 8, 9, 10, 18]),
        (Fault("reordered", 0.12, 0.06), [9, 5, 6, 5, 8, 7, 10, 9, 12, 18]),
    ],
    ids=lambda value: value.kind if isinstance(value, Fault) else "",
)
def test_a_frame_is_stamped_once_however_it_is_delivered(fault: Fault, stamps: list[int]) -> None:
    off = Fault("clock_jump", 0.10, 0.08, size=-0.05)
    for faults in ((off, fault), (fault, off)):
        seen = _ticks(*faults)[9 : 9 + len(stamps)]
        assert [tick.frame_stamp_ns // 10_000_000 for tick, _ in seen] == stamps
        assert [tick.frame.t for tick, _ in seen] == [tick.frame_stamp_ns * 1e-9 for tick, _ in seen]


def test_the_judged_share_of_thrust_is_the_injected_one_at_every_tick() -> None:
    faults = (
        Fault("weak_rotor", 0.29, 0.0, ("cf1",), 0.2),
        Fault("weak_rotor", 0.57, 0.1, ("cf2",), 0.2),
        Fault("battery_sag", 0.5, 0.0, ("cf1",), 0.1),
        Fault("battery_sag", 0.3, 0.4, ("cf2",), 0.1),
    )
    injection = FaultInjection(faults, ("cf1", "cf2"), TICK_NS, seed=0)
    stamps = TICK_NS * np.arange(100)
    given = [injection.weakened(np.ones((2, 7)), int(stamp))[:, 3:].mean(axis=1) for stamp in stamps]
    trace = SimpleNamespace(t=np.array([time_from_stamp(int(one)) for one in stamps]), names=("cf1", "cf2"))
    np.testing.assert_allclose(thrust_left(trace, faults), given, rtol=1e-12)


def test_rotors_lose_thrust_of_the_vehicles_that_are_named() -> None:
    faults = (
        Fault("weak_rotor", 0.1, 0.1, ("cf2",), 0.2),
        Fault("battery_sag", 0.1, 0.1, ("cf3",), 0.4),
    )
    injection = FaultInjection(faults, NAMES, TICK_NS, seed=0)
    given = np.arange(1.0, 22.0).reshape(3, 7)
    for tick, weak, sag in ((9, 0.0, 0.0), (15, 0.2, 0.2), (20, 0.0, 0.4)):
        left = given.copy()
        left[1, 3] *= 1.0 - weak  # rotor 1 follows the three columns of the rates
        left[2, 3:] *= 1.0 - sag
        np.testing.assert_allclose(injection.weakened(given.copy(), tick * TICK_NS), left, rtol=1e-12)


def test_packets_are_lost_by_the_vehicles_that_are_named_at_their_share() -> None:
    faults = (Fault("radio_loss", 0.1, 99.9, ("cf2",), 1.0), Fault("radio_loss", 0.1, 99.9, ("cf3",), 0.2))
    injection = FaultInjection(faults, NAMES, TICK_NS, seed=0)
    assert not injection.jammed(9 * TICK_NS).any()
    lost = np.array([injection.jammed(tick * TICK_NS) for tick in range(10, 10_000)])
    np.testing.assert_array_equal(lost.mean(axis=0)[:2], [0.0, 1.0])
    assert lost[:, 2].mean() == pytest.approx(0.2, abs=4.0 * 0.4 / 100.0)  # four standard deviations


def test_a_flight_without_packets_is_another() -> None:
    fault = Fault("radio_loss", 0.1, 0.4, ("cf2",), 1.0)
    scenario = replace(CALM, duration=0.6, wake="none", faults=(fault,))
    lost = fly(scenario, FlightOptions(mode="ignoring"))
    whole = fly(replace(scenario, faults=()), FlightOptions(mode="ignoring"))
    assert not np.array_equal(lost.true_pos[:, 1], whole.true_pos[:, 1])


def test_a_marker_that_jumps_keeps_its_body_when_names_are_exchanged_in_the_same_tick() -> None:
    """Bodies are displaced before their names are exchanged, in whichever order the faults are listed."""
    swap, jump = Fault("swap", 0.1, 0.1, ("cf1", "cf2")), Fault("jump", 0.1, 0.1, ("cf1",), -0.5)
    pos = np.array([[2.0, -1.0, 0.7], [1.0, 0.5, 1.2], [-1.0, 2.0, 0.9]])
    frame = MocapFrame(0.15, NAMES, pos, np.tile([0.0, 0.0, 0.0, 1.0], (3, 1)))
    for faults in ((swap, jump), (jump, swap)):
        injection = FaultInjection(faults, NAMES, TICK_NS, seed=0)
        injected = np.zeros(3, dtype=np.uint8)
        found = injection.deliver(frame, 15 * TICK_NS, injected).frame
        assert found.names == ("cf2", "cf1", "cf3")
        np.testing.assert_array_equal(found.pos - pos, [[-0.5, 0.0, 0.0], [0.0] * 3, [0.0] * 3])
        np.testing.assert_array_equal(injected, [Injected.SWAP | Injected.OUTLIER, Injected.SWAP, 0])


def test_a_weak_rotor_and_a_sagging_battery_cost_their_share_of_thrust() -> None:
    hover = CALM.vehicle.hover_thrust
    for kind, share in (("weak_rotor", 0.25 * 0.1), ("battery_sag", 0.1)):
        fault = Fault(kind, start=0.0, duration=0.01, vehicles=("cf1",), size=0.1)
        lasting = replace(fault, duration=0.5 if kind == "weak_rotor" else 0.01)
        room = Room(replace(CALM, faults=(lasting,)), seed=0)
        room.advance(None)
        room.advance(None)
        force = room.imu().specific_force_body[:, 2] * CALM.vehicle.mass
        # the downwash of half a metre away is not felt by the sensor's thrust, but pushes: 0.25 N
        downwash = room.capture().truth_interference.acc[:, 2] * CALM.vehicle.mass
        np.testing.assert_allclose(force - downwash, [hover * (1.0 - share), hover], rtol=2e-3)


@pytest.mark.parametrize(
    ("document", "word"),
    [
        ({"kind": "outlyer", "start": 1}, r"unknown fault 'outlyer'; did you mean outlier"),
        ({"kind": "outlier", "start": -1, "size": 1}, r"start = -1.0; must be at least 0 s"),
        ({"kind": "outlier", "start": float("nan"), "size": 1}, r"start = nan"),
        ({"kind": "outlier", "start": 1, "size": 1000}, r"size = 1000.0; must be in \[0.001, 100.0\] m"),
        ({"kind": "radio_loss", "start": 1, "size": 2}, r"size = 2.0; must be in \[0.0, 1.0\]"),
        ({"kind": "swap", "start": 1, "vehicles": ["cf1"]}, r"name exactly two different vehicles"),
        ({"kind": "swap", "start": 1, "vehicles": ["cf1", "cf1"]}, r"\['cf1', 'cf1'\]: name exactly two"),
        ({"kind": "stale", "start": 1, "vehicles": ["cf1"]}, r"acts on whole frames: name no vehicles"),
        ({"kind": "nan", "start": "soon"}, r"start = 'soon'; must be a number"),
        ({"kind": "nan", "begin": 1}, r"unknown key 'begin'"),
        ("nan", r"fault: got 'nan', expected a mapping with kind, start"),
    ],
)
def test_wrong_faults_are_refused_by_name(document: object, word: str) -> None:
    with pytest.raises(ValueError, match=word):
        from_plain(Fault, document, "fault")


def test_a_fault_of_a_stranger_is_refused() -> None:
    with pytest.raises(ValueError, match="fault nan: no vehicle 'cf9'; choose one of cf1, cf2"):
        replace(CALM, faults=(Fault("nan", 0.0, vehicles=("cf9",)),))


def test_random_faults_repeat_by_seed_and_are_of_every_kind() -> None:
    faults = random_faults(3, ("cf1", "cf2", "cf3"), 20.0, 300)
    assert faults == random_faults(3, ("cf1", "cf2", "cf3"), 20.0, 300)
    assert faults != random_faults(4, ("cf1", "cf2", "cf3"), 20.0, 300)
    assert {fault.kind for fault in faults} == set(KINDS)
    assert set(LENGTHS) == set(KINDS)
    assert set(SIZES) == {kind for kind, meaning in KINDS.items() if meaning.high > 0.0}
    assert all(fault.kind != "swap" for fault in random_faults(3, ("cf1",), 20.0, 300))


@pytest.mark.parametrize("kind", list(KINDS))
def test_a_flight_comes_through_a_fault_of_each_kind(kind: str) -> None:
    low, high = SIZES.get(kind, (0.0, 0.0))
    vehicles = ("cf1", "cf2") if kind == "swap" else () if KINDS[kind].whole_frame else ("cf1",)
    fault = Fault(
        kind, start=0.5, duration=min(LENGTHS[kind][1], 0.3), vehicles=vehicles, size=0.5 * (low + high)
    )
    scenario = replace(library.load("stack3"), duration=3.0, faults=(fault,))
    flight = fly(scenario, FlightOptions(model=find_model(scenario.model).interaction))
    assert np.isfinite(flight.true_pos).all()
    assert np.isfinite(flight.thrust).all()
    assert flight.t[-1] == pytest.approx(3.0 - TICK_S)
    # 0.3 s without sight or command in air of 0.1 m/s^2: centimetres; a sensor off by `jump` moves it
    worst = np.abs(flight.true_pos - flight.ref_pos).max()
    assert worst < 0.15 + (abs(fault.size) if kind == "jump" else 0.0)


def test_vehicles_may_be_any_sequence_of_names_and_no_single_one() -> None:
    listed = Fault("nan", 0.1, vehicles=["cf1"])  # type: ignore[arg-type]
    assert {listed} == {Fault("nan", 0.1, vehicles=("cf1",))}
    with pytest.raises(TypeError, match="fault nan: vehicles = 'cf1'; must be a list of names"):
        Fault("nan", 0.1, vehicles="cf1")  # type: ignore[arg-type]
