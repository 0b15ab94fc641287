"""Policies of what was observed and commanded: each sees its own breach."""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
import pytest
from changed_flights import AROUND, SCENARIO, Change, broken, changed, one_each, only, received, with_row

from q2q_model.signals.values import (
    CommandStatus,
    MocapFrame,
    SwarmCommand,
    SwarmState,
    TrackStatus,
)
from q2q_sim.faults.faults import Fault
from q2q_sim.monitors.policies import (
    POLICIES,
    RecordedSignal,
    judge,
    trace_of,
)


def test_a_command_on_an_old_state_breaks_the_age_unless_it_says_so() -> None:
    old = changed(SwarmState, 3.0, 3.05, age=with_row(1, 0.06))
    assert broken(old) == {"state_age"}
    says = changed(SwarmCommand, 3.0, 3.05, status=with_row(1, CommandStatus.DEGRADED))
    assert broken(lambda one: says(old(one))) == set()


@pytest.mark.parametrize(("attribute", "value", "broken_by_it"), [
    ("quat", np.nan, set()), ("quat", np.inf, {"numbers"}), ("vel", np.nan, {"numbers"}),
])  # fmt: skip
def test_a_state_may_not_know_an_attitude(attribute: str, value: float, broken_by_it: set[str]) -> None:
    unknown = changed(SwarmState, 0.0, 0.015, **{attribute: with_row(1, value)})
    assert broken(unknown) == broken_by_it


def test_an_unseen_vehicle_flown_as_usual_breaks_the_action_after_60_ms() -> None:
    def gone(ticks: int) -> Change:
        # NaN: seen as nowhere
        return changed(MocapFrame, 3.0, 3.0 + ticks * 0.01 - 0.005, pos=with_row(0, np.nan))

    def gone_and_marked(one: RecordedSignal) -> RecordedSignal:
        late = changed(SwarmCommand, 3.06, 3.5, status=with_row(0, CommandStatus.HOLD))
        return late(gone(7)(one))

    unmarked = changed(SwarmCommand, 2.9, 3.5, status=with_row(0, CommandStatus.OK))
    assert "fallback_latency" not in broken(
        lambda one: unmarked(gone(6)(one))
    )  # 0.06 s after it was last seen
    assert "fallback_latency" in broken(lambda one: unmarked(gone(7)(one)))
    assert "fallback_latency" not in broken(gone_and_marked)


def test_who_is_unseen_after_a_clock_jump_is_so_since_its_stamps_are_over() -> None:
    gone = changed(MocapFrame, 3.0, 3.5, pos=with_row(0, np.nan))
    unmarked = changed(SwarmCommand, 2.9, 3.5, status=with_row(0, CommandStatus.OK))

    def after(jump: Fault) -> bool:
        around = replace(AROUND, faults=(jump,))
        return "fallback_latency" in broken(lambda one: unmarked(gone(one)), around)

    assert not after(Fault("clock_jump", 2.9, 0.15, size=0.40))  # stamps up to 3.45
    assert after(Fault("clock_jump", 2.9, 0.15, size=0.30))  # up to 3.35: 0.15 s before it is seen again


def test_who_is_missing_is_not_judged_while_two_may_be_taken_for_each_other() -> None:
    gone = changed(MocapFrame, 3.0, 3.1, pos=with_row(0, np.nan))
    unmarked = changed(SwarmCommand, 2.9, 3.5, status=with_row(0, CommandStatus.OK))

    def under(fault: Fault) -> bool:
        around = replace(AROUND, faults=(fault,))
        return "fallback_latency" in broken(lambda one: unmarked(gone(one)), around)

    names = received()[0].signal.names[:2]
    assert not under(Fault("swap", 2.0, 0.15, vehicles=names))  # over 0.95 s before the last frame without it
    assert under(Fault("swap", 1.8, 0.15, vehicles=names))  # 1.15 s before
    assert under(Fault("jump", 2.0, 0.15, vehicles=names, size=0.1))  # another place, but its own name


def test_a_vehicle_is_seen_by_any_frame_of_a_stamp_that_comes_again() -> None:
    # a clock ahead shows stamps to come; set right again, it shows the same stamps without the vehicle
    blind = [changed(MocapFrame, 3.0, 3.2, pos=with_row(0, np.nan))(one) for one in received()]
    ahead = [one for one in received() if one.topic == "mocap" and 3.0 <= one.signal.t < 3.195]
    unmarked = changed(SwarmCommand, 2.9, 3.5, status=with_row(0, CommandStatus.OK))
    assert "fallback_latency" in {one.policy for one in judge(trace_of(map(unmarked, blind)), AROUND)}
    assert "fallback_latency" not in {
        one.policy for one in judge(trace_of(map(unmarked, [*ahead, *blind])), AROUND)
    }


def silent_in(recorded: Iterable[RecordedSignal]) -> dict[str, float]:
    """Return for how long which vehicles are silent [s] in a live recording."""
    live = (replace(one, at=one.at + 100.0) for one in recorded)
    found = judge(trace_of(live), AROUND, {"silence": POLICIES["silence"]})
    return {one.who: round(one.value, 6) for one in found}


def without_commands(recorded: Iterable[RecordedSignal], since: float, until: float) -> list[RecordedSignal]:
    return [one for one in recorded if not (one.topic == "command" and since <= one.signal.t < until)]


def test_a_silent_controller_breaks_the_silence_of_a_live_flight_only() -> None:
    silent = without_commands(received(), 3.0, 3.065)
    assert {one.policy for one in judge(trace_of(silent), AROUND)} == set()
    assert silent_in(received()) == {}
    assert silent_in(silent) == dict.fromkeys(SCENARIO.names, 0.08)


def test_silence_begins_at_a_stamp_whenever_it_was_recorded() -> None:
    live = (replace(one, at=one.at + 1.8e9) for one in without_commands(received(), 3.0, 3.065))
    found = judge(trace_of(live), AROUND, {"silence": POLICIES["silence"]})
    assert [round(one.t, 6) for one in found] == [2.99] * len(SCENARIO.names)


def test_one_silent_controller_of_several_breaks_the_silence_of_its_vehicle() -> None:
    def of_cf2(one: RecordedSignal) -> bool:
        return one.topic == "command" and one.signal.names == ("cf2",) and 3.0 <= one.signal.t < 4.995

    assert silent_in(one for one in one_each(received()) if not of_cf2(one)) == {"cf2": 2.01}


def test_a_command_that_is_repeated_under_its_stamp_is_silence() -> None:
    held = next(one.signal for one in received() if one.topic == "command" and one.signal.t >= 2.995)
    repeated = [
        replace(one, signal=held) if one.topic == "command" and 3.0 < one.signal.t < 4.995 else one
        for one in received()
    ]
    assert silent_in(repeated) == dict.fromkeys(SCENARIO.names, 2.0)


@pytest.mark.parametrize(("since", "silent_s"), [(4.0, 4.0), (7.6, None)])
def test_commands_that_end_in_the_air_are_silence_but_where_the_recording_ends_with_them(
    since: float, silent_s: float | None
) -> None:
    found = silent_in(without_commands(received(), since - 0.005, np.inf))
    assert found == ({} if silent_s is None else dict.fromkeys(SCENARIO.names, silent_s))


@pytest.mark.parametrize(("since", "until"), [(4.0, 8.1), (4.0, 5.0), (3.0, 3.5)])
def test_a_vehicle_on_the_ground_needs_no_commands_nor_one_that_comes_down_without(
    since: float, until: float
) -> None:
    """It has landed, is carried away, or its own commander lands it; the policy `floor` reports falls."""
    down = only("truth", changed(SwarmState, since, until, pos=with_row(1, np.array([0.0, 0.0, 0.05]))))
    found = silent_in(map(down, without_commands(received(), 3.0 - 0.005, np.inf)))
    assert found == dict.fromkeys((SCENARIO.names[0], SCENARIO.names[2]), 5.0)


def test_a_false_state_breaks_state_error_unless_it_is_coasting_or_a_sensor_lies_steadily() -> None:
    false = only("state", changed(SwarmState, 3.0, 3.05, pos=lambda pos: pos + np.array([0.0, 0.0, 0.12])))
    assert broken(false) == {"state_error"}
    coasting = only(
        "state", changed(SwarmState, 3.0, 3.05, status=lambda _: np.full(3, TrackStatus.COASTING))
    )
    assert broken(lambda one: coasting(false(one))) == set()
    lie = replace(AROUND, faults=(Fault("jump", 2.8, 0.3, SCENARIO.names, 0.12),))
    assert broken(false, lie) == set()
    outlier = replace(AROUND, faults=(Fault("outlier", 2.8, 0.3, SCENARIO.names, 0.12),))
    assert "state_error" in broken(false, outlier)


@pytest.mark.parametrize(("lost_s", "judged"), [(0.01, True), (0.4, True), (0.55, False)])
def test_setpoints_lost_for_less_than_half_a_second_do_not_hide_who_does_not_come_back(
    lost_s: float, judged: bool
) -> None:
    def lost(one: RecordedSignal) -> bool:
        return one.topic == "reference_safe" and (one.signal.t + 0.005) % (0.4 + lost_s) > 0.4

    away = only("truth", changed(SwarmState, 6.0, 8.0, pos=lambda pos: pos + np.array([0.0, 0.4, 0.0])))
    recorded = [away(one) for one in received() if not lost(one)]
    assert ("return" in {one.policy for one in judge(trace_of(recorded), AROUND)}) == judged


def test_a_vehicle_seen_for_less_than_half_a_second_is_not_told_to_stay_away_from_its_setpoint() -> None:
    away = only("truth", changed(SwarmState, 0.0, 8.0, pos=lambda pos: pos + np.array([0.0, 0.4, 0.0])))
    for duration, judged in ((0.49, False), (0.51, True)):
        unseen = only("truth", changed(SwarmState, 0.0, 8.0 - duration - 0.005, pos=with_row(0, np.nan)))
        found = judge(trace_of(unseen(away(one)) for one in received()), AROUND)
        assert (("return", "cf1") in {(one.policy, one.who) for one in found}) == judged
