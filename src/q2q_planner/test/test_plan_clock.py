"""Prove that a plan starts when it is told to, or at the first tick, and says so once."""

from q2q_planner.plan_clock import PlanClock


def test_without_a_start_the_first_tick_is_it() -> None:
    clock = PlanClock(-1.0)
    assert [clock.starts_with(t) for t in (3.25, 3.26, 1.0)] == [True, False, False]
    assert (clock.start, clock.start_ns) == (3.25, 3_250_000_000)


def test_a_given_start_needs_no_tick() -> None:
    clock = PlanClock(0.5)
    assert not clock.starts_with(3.25)
    assert clock.start_ns == 500_000_000
