"""Policies of commands: thrust, tilt and numbers, in one message or in several."""

from dataclasses import replace

import numpy as np
import pytest
from changed_flights import AROUND, SCENARIO, Change, broken, changed, one_each, received, with_row

from q2q_model.signals.values import (
    SwarmCommand,
    SwarmSetpoint,
    SwarmState,
)
from q2q_sim.monitors.policies import (
    RecordedSignal,
    judge,
    policies_without_evidence,
    trace_of,
)


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


def test_commands_in_one_message_for_each_vehicle_are_judged_as_those_in_one_for_all() -> None:
    bad = changed(SwarmCommand, 3.0, 4.0, thrust=with_row(0, -0.5), roll=with_row(0, 1.5))
    recorded = [bad(one) for one in received()]
    whole, parts = trace_of(recorded), trace_of(one_each(recorded))
    np.testing.assert_array_equal(parts.thrust, whole.thrust)
    assert judge(parts, AROUND) == judge(whole, AROUND)
    assert {(one.policy, one.who) for one in judge(parts, AROUND)} == {("thrust", "cf1"), ("tilt", "cf1")}


def test_of_two_messages_with_a_vehicle_and_a_stamp_the_later_recorded_counts() -> None:
    whole = [one for one in received() if one.topic in {"command", "truth"}]
    parts = one_each(whole)
    double = changed(SwarmCommand, 0.0, 8.0, thrust=lambda thrust: 2.0 * thrust)
    doubled = [double(one) for one in parts if "cf2" in one.signal.names]
    once = trace_of(whole).thrust
    np.testing.assert_array_equal(trace_of([*whole, *doubled]).thrust, once * [1.0, 2.0, 1.0])
    np.testing.assert_array_equal(trace_of([*doubled, *whole]).thrust, once)
    np.testing.assert_array_equal(trace_of([parts[0], *doubled, *whole]).thrust, once)


def test_tilt_counts_roll_and_pitch_together() -> None:
    # cos(tilt) = cos(roll) cos(pitch): 0.27 and 0.27 make 0.379
    both = changed(SwarmCommand, 3.0, 3.01, roll=with_row(0, 0.27), pitch=with_row(0, 0.27))
    assert broken(both) == {"tilt"}
    assert broken(changed(SwarmCommand, 3.0, 3.01, roll=with_row(0, 0.27))) == set()


def as_table(one: RecordedSignal) -> RecordedSignal:
    """Return a signal as bag_import makes it of a table, which has neither yaw rates nor commanded angles."""
    for kind, lacked in ((SwarmCommand, ("roll", "pitch", "yaw_rate")), (SwarmSetpoint, ("yaw_rate",))):
        for column in lacked:
            one = changed(kind, -1.0, 9.0, **{column: lambda values: values * np.nan})(one)
    return one


def test_what_is_nan_throughout_a_table_was_not_recorded_and_what_is_nan_at_times_is_broken() -> None:
    table = [as_table(one) for one in received() if one.topic in {"mocap", "state", "reference", "command"}]

    def found(change: Change) -> set[str]:
        return {one.policy for one in judge(trace_of(map(change, table)), AROUND)}

    rates = changed(SwarmState, -1.0, 9.0, ang_vel_body=lambda rate: rate * np.nan)
    assert found(rates) == set()
    assert "tilt" in policies_without_evidence(trace_of(table))
    assert found(changed(SwarmState, 0.5, 9.0, ang_vel_body=lambda rate: rate * np.nan)) == {"numbers"}
    assert found(changed(SwarmState, 0.5, 9.0, ang_vel_body=with_row(1, np.nan))) == {"numbers"}
    for kind, column in ((SwarmCommand, "thrust"), (SwarmState, "vel"), (SwarmSetpoint, "pos")):
        assert "numbers" not in found(changed(kind, -1.0, 9.0, **{column: lambda values: values * np.nan}))
        for since, count in ((-1.0, 0), (0.5, 1)):
            of_one = changed(kind, since, 9.0, **{column: with_row(1, np.nan)})
            assert len(trace_of(map(of_one, table)).not_finite) == count
    assert "numbers" in found(changed(SwarmCommand, -1.0, 9.0, thrust=lambda thrust: thrust + np.inf))


@pytest.mark.parametrize(
    ("kind", "column"),
    [(SwarmCommand, "thrust"), (SwarmCommand, "roll"), (SwarmState, "vel"), (SwarmSetpoint, "yaw_rate")],
)
def test_what_is_nan_throughout_a_flight_in_lockstep_is_broken_without_true_positions_too(
    kind: type, column: str
) -> None:
    everywhere = changed(kind, -1.0, 9.0, **{column: lambda values: values * np.nan})
    lockstep = [one for one in received() if one.topic not in {"truth", "truth_interference"}]
    assert any(f"{column} is not finite" in one for one in trace_of(map(everywhere, lockstep)).not_finite)


@pytest.mark.parametrize(
    "topics", [("mocap", "state", "reference", "command"), ("mocap", "state", "command")]
)
def test_commands_of_a_flight_in_lockstep_without_any_number_are_broken(topics: tuple[str, ...]) -> None:
    silent = changed(
        SwarmCommand,
        -1.0,
        9.0,
        **{name: lambda values: values * np.nan for name in ("thrust", "roll", "pitch", "yaw_rate")},
    )
    lockstep = [one for one in received() if one.topic in topics]
    assert any("command" in one for one in trace_of(map(silent, lockstep)).not_finite)


@pytest.mark.parametrize(
    ("kind", "column"), [(SwarmCommand, "roll"), (SwarmState, "vel"), (SwarmSetpoint, "pos")]
)
def test_what_a_node_sends_as_nan_throughout_is_broken(kind: type, column: str) -> None:
    """A simulator has true positions; live signals are recorded later than they are stamped."""
    everywhere = changed(kind, -1.0, 9.0, **{column: lambda values: values * np.nan})
    assert "numbers" in broken(everywhere)
    live = [replace(one, at=one.at + 0.01) for one in received() if one.topic != "truth"]
    assert {one.policy for one in judge(trace_of(map(everywhere, live)), AROUND)} >= {"numbers"}
