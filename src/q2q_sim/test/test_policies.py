"""Each policy sees its own breach, and that a flight without one keeps them all."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from q2q_model.bag import BagWriter
from q2q_model.files.find_model import find_model
from q2q_model.signals.values import (
    CommandStatus,
    Interference,
    MocapFrame,
    SwarmCommand,
    SwarmSetpoint,
    SwarmState,
    TrackStatus,
)
from q2q_model.vehicle.constants import CRAZYFLIE_2_0, GRAVITY
from q2q_sim.commands import policies as tool
from q2q_sim.experiments.campaign import campaign_flight
from q2q_sim.experiments.campaign.random_run import GAINS, drawn
from q2q_sim.faults.faults import Fault
from q2q_sim.link.radio import RadioParams
from q2q_sim.loop.closed_loop import FlightOptions, fly
from q2q_sim.monitors.policies import (
    POLICIES,
    Circumstances,
    RecordedSignal,
    evidence_in_lockstep,
    evidence_of,
    judge,
)
from q2q_sim.scenarios import library
from q2q_sim.sensors.vicon import ViconParams

SCENARIO = replace(library.load("stack3"), duration=8.0, vicon=ViconParams(), radio=RadioParams())
AROUND = Circumstances(vehicle=SCENARIO.vehicle)
Change = Callable[[RecordedSignal], RecordedSignal]


@cache
def received() -> tuple[RecordedSignal, ...]:
    """Return what a flight of three vehicles without faults says."""
    found: list[RecordedSignal] = []
    options = FlightOptions(
        model=find_model(SCENARIO.model).interaction,
        on_signal=lambda topic, stamp_ns, signal: found.append(
            RecordedSignal(topic, stamp_ns * 1e-9, signal)
        ),
    )
    fly(SCENARIO, options)
    return tuple(found)


def broken(change: Change, around: Circumstances = AROUND) -> set[str]:
    return {one.policy for one in judge(evidence_of(map(change, received())), around)}


def changed(kind: type, since: float, until: float, **columns: Callable[[np.ndarray], np.ndarray]) -> Change:
    """Return a change of signals of a kind from a time to another."""

    def change(one: RecordedSignal) -> RecordedSignal:
        if not isinstance(one.signal, kind) or not since <= one.signal.t < until:
            return one
        new = {key: edit(getattr(one.signal, key).copy()) for key, edit in columns.items()}
        return replace(one, signal=replace(one.signal, **new))

    return change


def only(topic: str, change: Change) -> Change:
    return lambda one: change(one) if one.topic == topic else one


def with_row(row: int, value: float | np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
    def edit(column: np.ndarray) -> np.ndarray:
        column[row] = value
        return column

    return edit


def test_a_flight_without_faults_keeps_every_policy() -> None:
    assert broken(lambda one: one) == set()
    assert len(POLICIES) == 12


def test_two_vehicles_that_touch_break_the_separation_and_who_strays_the_room() -> None:
    at = received()[0].signal
    assert isinstance(at, SwarmState)
    near = only(
        "truth", changed(SwarmState, 3.0, 3.1, pos=with_row(0, at.pos[1] + np.array([0.0, 0.10, 0.0])))
    )
    assert {"separation", "room"} <= broken(near)
    apart = only(
        "truth", changed(SwarmState, 3.0, 3.1, pos=with_row(0, at.pos[1] + np.array([0.0, 0.20, 0.0])))
    )
    assert "separation" not in broken(apart)
    for size, touch in ((0.01, True), (0.05, False)):  # beside the distance, of 0.14 m
        displaced = Fault("jump", 2.9, 0.3, (at.names[0],), size)
        assert ("separation" in broken(near, replace(AROUND, faults=(displaced,)))) == touch


@pytest.mark.parametrize(
    ("off", "strays"), [((0.0, 0.0, -1.6), False), ((0.0, 0.0, 1.6), True), ((1.6, 0.0, -0.1), True)]
)
def test_a_vehicle_that_lands_blind_is_sent_down_and_nowhere_else(
    off: tuple[float, float, float], strays: bool
) -> None:
    away = only("truth", changed(SwarmState, 3.0, 3.1, pos=lambda pos: pos + np.array(off)))
    lands = changed(SwarmCommand, 2.0, 3.05, status=lambda _: np.full(3, CommandStatus.LAND))
    assert "room" in broken(away)
    assert ("room" in broken(lambda one: lands(away(one)))) == strays


def test_a_vehicle_whose_marker_is_moved_may_be_so_much_farther() -> None:
    away = only("truth", changed(SwarmState, 3.0, 3.1, pos=lambda pos: pos + np.array([1.8, 0.0, 0.0])))

    def around(size: float, start: float = 2.9) -> Circumstances:
        return replace(
            AROUND, faults=(Fault("jump", start, 0.3, vehicles=received()[0].signal.names, size=size),)
        )

    assert "room" in broken(away, around(0.2))
    assert "room" not in broken(away, around(-0.4))
    assert "room" in broken(away, around(-0.4, start=1.6))  # moved back 1.1 s before


def test_a_vehicle_in_the_zone_breaks_it_only_where_it_was_sent_clear_of_it() -> None:
    at = received()[0].signal
    assert isinstance(at, SwarmState)
    below = at.pos[1] - np.array([0.0, 0.0, 0.6])
    stray = only("truth", changed(SwarmState, 3.0, 3.1, pos=with_row(0, below)))
    assert "zone" in broken(stray)
    sent = changed(SwarmSetpoint, 3.0, 3.1, pos=with_row(0, below))
    assert "zone" not in broken(lambda one: sent(stray(one)))


@pytest.mark.parametrize(
    ("column", "value", "policy"),
    [
        ("thrust", SCENARIO.vehicle.thrust_max * 1.01, "thrust"),
        ("thrust", -0.001, "thrust"),
        ("roll", 0.37, "tilt"),
        ("pitch", -0.37, "tilt"),
        ("yaw_rate", np.nan, "numbers"),
        ("thrust", np.inf, "numbers"),
    ],
)
def test_a_command_out_of_bounds_breaks_its_policy(column: str, value: float, policy: str) -> None:
    found = broken(changed(SwarmCommand, 3.0, 3.01, **{column: with_row(2, value)}))
    assert policy in found
    assert found <= {policy, "thrust"}


def test_tilt_counts_roll_and_pitch_together() -> None:
    # cos(tilt) = cos(roll) cos(pitch): 0.27 and 0.27 make 0.379
    both = changed(SwarmCommand, 3.0, 3.01, roll=with_row(0, 0.27), pitch=with_row(0, 0.27))
    assert broken(both) == {"tilt"}
    assert broken(changed(SwarmCommand, 3.0, 3.01, roll=with_row(0, 0.27))) == set()


def test_a_command_on_an_old_state_breaks_the_age_unless_it_says_so() -> None:
    old = changed(SwarmState, 3.0, 3.05, age=with_row(1, 0.06))
    assert broken(old) == {"age"}
    says = changed(SwarmCommand, 3.0, 3.05, status=with_row(1, CommandStatus.DEGRADED))
    assert broken(lambda one: says(old(one))) == set()


def test_an_unseen_vehicle_flown_as_usual_breaks_the_action_after_60_ms() -> None:
    def gone(ticks: int) -> Change:
        # NaN: seen as nowhere
        return changed(MocapFrame, 3.0, 3.0 + ticks * 0.01 - 0.005, pos=with_row(0, np.nan))

    def gone_and_marked(one: RecordedSignal) -> RecordedSignal:
        late = changed(SwarmCommand, 3.06, 3.5, status=with_row(0, CommandStatus.HOLD))
        return late(gone(7)(one))

    unmarked = changed(SwarmCommand, 2.9, 3.5, status=with_row(0, CommandStatus.OK))
    assert "action" not in broken(lambda one: unmarked(gone(6)(one)))  # 0.06 s after it was last seen
    assert "action" in broken(lambda one: unmarked(gone(7)(one)))
    assert "action" not in broken(gone_and_marked)


def test_who_is_unseen_after_a_clock_jump_is_so_since_its_stamps_are_over() -> None:
    gone = changed(MocapFrame, 3.0, 3.5, pos=with_row(0, np.nan))
    unmarked = changed(SwarmCommand, 2.9, 3.5, status=with_row(0, CommandStatus.OK))

    def after(jump: Fault) -> bool:
        around = replace(AROUND, faults=(jump,))
        return "action" in broken(lambda one: unmarked(gone(one)), around)

    assert not after(Fault("clock_jump", 2.9, 0.15, size=0.40))  # stamps up to 3.45
    assert after(Fault("clock_jump", 2.9, 0.15, size=0.30))  # up to 3.35: 0.15 s before it is seen again


def test_who_is_missing_is_not_judged_while_two_may_be_taken_for_each_other() -> None:
    gone = changed(MocapFrame, 3.0, 3.1, pos=with_row(0, np.nan))
    unmarked = changed(SwarmCommand, 2.9, 3.5, status=with_row(0, CommandStatus.OK))

    def under(fault: Fault) -> bool:
        around = replace(AROUND, faults=(fault,))
        return "action" in broken(lambda one: unmarked(gone(one)), around)

    names = received()[0].signal.names[:2]
    assert not under(Fault("swap", 2.0, 0.15, vehicles=names))  # over 0.95 s before the last frame without it
    assert under(Fault("swap", 1.8, 0.15, vehicles=names))  # 1.15 s before
    assert under(Fault("jump", 2.0, 0.15, vehicles=names, size=0.1))  # another place, but its own name


def test_a_vehicle_is_seen_by_any_frame_of_a_stamp_that_comes_again() -> None:
    # a clock ahead shows stamps to come; set right again, it shows the same stamps without the vehicle
    blind = [changed(MocapFrame, 3.0, 3.2, pos=with_row(0, np.nan))(one) for one in received()]
    ahead = [one for one in received() if one.topic == "mocap" and 3.0 <= one.signal.t < 3.195]
    unmarked = changed(SwarmCommand, 2.9, 3.5, status=with_row(0, CommandStatus.OK))
    assert "action" in {one.policy for one in judge(evidence_of(map(unmarked, blind)), AROUND)}
    assert "action" not in {one.policy for one in judge(evidence_of(map(unmarked, [*ahead, *blind])), AROUND)}


def test_a_silent_controller_breaks_the_silence_of_a_live_flight_only() -> None:
    def told_late(one: RecordedSignal) -> RecordedSignal:
        return replace(one, at=one.at + 100.0)

    silent = [one for one in received() if not (one.topic == "command" and 3.0 <= one.signal.t < 3.065)]
    assert {one.policy for one in judge(evidence_of(silent), AROUND)} == set()
    (found,) = judge(evidence_of(map(told_late, silent)), AROUND)
    assert found.policy == "silence"
    assert found.value == pytest.approx(0.08, abs=1e-6)


def test_a_false_state_breaks_the_belief_unless_it_is_coasting_or_a_sensor_lies_steadily() -> None:
    false = only("state", changed(SwarmState, 3.0, 3.05, pos=lambda pos: pos + np.array([0.0, 0.0, 0.12])))
    assert broken(false) == {"belief"}
    coasting = only(
        "state", changed(SwarmState, 3.0, 3.05, status=lambda _: np.full(3, TrackStatus.COASTING))
    )
    assert broken(lambda one: coasting(false(one))) == set()
    lie = replace(AROUND, faults=(Fault("jump", 2.8, 0.3, SCENARIO.names, 0.12),))
    assert broken(false, lie) == set()
    outlier = replace(AROUND, faults=(Fault("outlier", 2.8, 0.3, SCENARIO.names, 0.12),))
    assert "belief" in broken(false, outlier)


def test_a_vehicle_that_does_not_come_back_breaks_the_return_once_it_had_its_time() -> None:
    away = only("truth", changed(SwarmState, 7.0, 8.0, pos=lambda pos: pos + np.array([0.0, 0.4, 0.0])))
    assert "return" in broken(away)
    recent = replace(AROUND, faults=(Fault("weak_rotor", 4.0, 1.0, ("cf1",), 0.1),))
    assert "return" not in broken(away, recent)
    earlier = replace(AROUND, faults=(Fault("weak_rotor", 2.0, 1.0, ("cf1",), 0.1),))
    assert "return" in broken(away, earlier)
    for duration, lasts in ((0.49, False), (0.51, True)):
        briefly = changed(SwarmState, 7.0, 7.0 + duration, pos=lambda pos: pos + np.array([0.0, 0.4, 0.0]))
        assert ("return" in broken(only("truth", briefly))) == lasts


def test_a_push_beyond_the_thrust_excuses_and_a_weak_controller_with_thrust_to_spare_does_not() -> None:
    """Run 15 on today's stock firmware: two wakes push the lowest of three by more than its thrust holds."""
    most = {"thrust_max": CRAZYFLIE_2_0.thrust_max}
    stock = {"firmware": "stock", "overrides": {"pid": GAINS | most, "mpc": most}, "faults": []}
    run = replace(drawn(15), document={**drawn(15).document, **stock})
    flown = campaign_flight.flown_pure(run)
    assert flown.violations == ()
    blind = {topic: found for topic, found in flown.topics.items() if topic != "truth_interference"}
    unaware = evidence_in_lockstep(blind)
    assert {one.policy for one in judge(unaware, campaign_flight.circumstances_of(run))} == {"return"}
    light = {**run.document, "vehicle": "crazyflie_2_1"}  # 27 g with the same motors
    assert campaign_flight.flown_pure(replace(run, document=light)).violations == ()
    weak = {"pid": GAINS | {"k_p_z": 4.0, "k_i_z": 0.0}}
    mutant = replace(
        run, document={**light, "overrides": weak}, options=replace(run.options, mode="ignoring")
    )
    assert "return" in {one.policy for one in campaign_flight.flown_pure(mutant).violations}


def test_a_violation_tells_who_when_and_how_much() -> None:
    change = changed(SwarmCommand, 3.0, 3.01, roll=with_row(2, 0.5))
    (found,) = judge(evidence_of(map(change, received())), AROUND)
    assert (found.policy, found.who, found.limit) == ("tilt", "cf3", 0.36)
    assert found.t == pytest.approx(3.0)
    assert found.value == pytest.approx(0.5, abs=0.1)
    assert str(found).startswith("tilt: cf3 at 3.00 s: 0.5")


def test_no_ticks_are_no_flight() -> None:
    with pytest.raises(ValueError, match="no ticks: a flight needs one of truth"):
        evidence_of([])


def test_a_bag_is_judged_as_its_signals_are(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    change = changed(SwarmCommand, 3.0, 3.01, roll=with_row(2, 0.5))
    for name, edit in (("good", lambda one: one), ("bad", change)):
        with BagWriter(tmp_path / name) as writer:
            for one in map(edit, received()):
                writer.write_signal(f"/{one.topic}", round(one.at * 1e9), one.signal)
    assert tool.main([str(tmp_path / "good")]) == 0
    assert "keeps separation, zone" in capsys.readouterr().out
    assert tool.main([str(tmp_path / "bad"), "--scenario", "stack3"]) == 1
    assert "tilt: cf3 at 3.00 s" in capsys.readouterr().out
    assert tool.main([str(tmp_path / "none")]) == 2
    assert "no bag at" in capsys.readouterr().err


def test_who_is_on_the_floor_though_sent_above_it_has_fallen_unless_it_lands_blind() -> None:
    fall = only("truth", changed(SwarmState, 3.0, 3.1, pos=lambda pos: pos * [1.0, 1.0, 0.0]))
    low = changed(SwarmSetpoint, 3.0, 3.1, pos=lambda pos: pos * [1.0, 1.0, 0.0])
    lands = changed(SwarmCommand, 2.0, 3.05, status=lambda _: np.full(3, CommandStatus.LAND))
    assert "floor" in broken(fall)
    assert "floor" not in broken(lambda one: low(fall(one)))
    assert "floor" not in broken(lambda one: lands(fall(one)))


def test_who_is_pushed_down_by_more_than_it_can_hold_is_not_judged_for_it() -> None:
    """The largest thrust, less what faults take, holds a downwash up to a known one: more or less."""
    vehicle = SCENARIO.vehicle
    fall = only("truth", changed(SwarmState, 3.0, 3.1, pos=lambda pos: pos * [1.0, 1.0, 0.0]))

    def pushed(by: float) -> Change:
        downwash = changed(Interference, 2.0, 3.05, acc=lambda acc: np.full_like(acc, [0.0, 0.0, -by]))
        return lambda one: only("truth_interference", downwash)(fall(one))

    sag = Fault("battery_sag", 0.0, 1.0, (), 0.1)
    weak = Fault("weak_rotor", 2.0, 2.0, (), 0.2)
    gone = Fault("weak_rotor", 1.0, 0.5, (), 0.2)
    for faults, left in (((), 1.0), ((sag,), 0.9), ((sag, weak), 0.9 * 0.95), ((gone,), 1.0)):
        around = replace(AROUND, faults=faults)
        held = left * vehicle.rpyt_thrust_max / vehicle.mass - GRAVITY
        assert {"floor"} <= broken(pushed(held - 0.01), around)
        assert not {"floor", "room", "zone", "return"} & broken(pushed(held + 0.01), around)
    named = replace(AROUND, faults=(replace(sag, vehicles=("cf2", "cf3")),))
    assert "floor" in broken(pushed(0.95 * vehicle.rpyt_thrust_max / vehicle.mass - GRAVITY), named)
