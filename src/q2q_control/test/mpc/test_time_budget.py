"""A budget ends when its clock says so, and begins again with each tick."""

from q2q_control.mpc.time_budget import TimeBudget


def test_time_is_left_until_the_clock_has_moved_by_the_budget() -> None:
    now = [100.0]
    budget = TimeBudget(0.006, lambda: now[0])
    assert budget.in_time()
    for _ in range(2):
        budget.begin()
        assert budget.in_time()
        now[0] += 0.0059
        assert budget.in_time()
        now[0] += 0.0002
        assert not budget.in_time()
