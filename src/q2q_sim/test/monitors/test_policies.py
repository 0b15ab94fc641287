"""A flight without a breach keeps every policy, and a violation says who, when and how much."""

from dataclasses import replace

import pytest
from changed_flights import AROUND, broken, changed, received, with_row

from q2q_model.signals.values import (
    SwarmCommand,
)
from q2q_sim.monitors.policies import (
    POLICIES,
    Violation,
    judge,
    trace_of,
)


def test_a_flight_without_faults_keeps_every_policy() -> None:
    assert broken(lambda one: one) == set()
    assert len(POLICIES) == 12


def test_a_violation_says_what_was_measured_and_its_unit() -> None:
    texts = {policy: str(Violation(policy, "cf1", 8.97, 1.8932, 1.5)) for policy in POLICIES}
    assert (
        texts["setpoint_error"] == "setpoint_error: cf1 at 8.97 s: 1.893 m from its setpoint (maximum 1.5 m)"
    )
    assert texts["silence"] == "silence: cf1 at 8.97 s: no command for 1.893 s (maximum 1.5 s)"
    assert [policy for policy, words in texts.items() if "(limit 1.5)" in words] == ["numbers"]
    not_finite = Violation("numbers", "cf1's thrust", float("nan"), float("nan"), 0.0)
    assert str(not_finite) == "numbers: cf1's thrust"
    assert str(Violation("stale_reported_ok", "cf1", 1.0, 0.07, 0.06)).endswith(
        "OK on a state 0.07 s old (maximum 0.06 s)"
    )
    repeated = Violation("repeat_reported_ok", "cf1", 1.0, 3.0, 0.0)
    assert str(repeated) == "repeat_reported_ok: cf1 at 1.00 s: 3 (limit 0)"


def test_a_violation_reports_who_when_and_how_much() -> None:
    change = changed(SwarmCommand, 3.0, 3.01, roll=with_row(2, 0.5))
    (found,) = judge(trace_of(map(change, received())), AROUND)
    assert (found.policy, found.who, found.limit) == ("tilt", "cf3", 0.36)
    assert found.t == pytest.approx(3.0)
    assert found.value == pytest.approx(0.5, abs=0.1)
    assert (
        str(replace(found, value=0.5)) == "tilt: cf3 at 3.00 s: 0.5 rad of commanded tilt (maximum 0.36 rad)"
    )


def test_no_ticks_are_no_flight() -> None:
    with pytest.raises(ValueError, match="no ticks: a flight needs one of truth"):
        trace_of([])
