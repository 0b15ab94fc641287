"""A plan that is not that of the setpoints is reported, by its time and by its place, as long as it is so."""

from dataclasses import replace

import numpy as np
import pytest
from pid_swarms import swarm

from q2q_control.inputs.plan_mismatch import PlanMismatchMonitor, far_from_plan
from q2q_control.inputs.plan_samples import sampled_preview
from q2q_control.inputs.preview import SampledPreview
from q2q_model.signals.values import SwarmSetpoint
from q2q_model.trajectory.polynomials import Trajectory

NAMES = ("cf1", "cf2")
ALONG_X = Trajectory(np.array([4.0]), np.array([[[0.0, 1.0], [0.0, 0.0], [0.0, 0.0], [0.0, 0.0]]]))
"""4 s at 1 m/s."""
FAR = "plan: far from the setpoints: cf2 {} m: check that they come from this plan"
OVER = (
    "plan: ended {} s before it arrived, far from the setpoints: cf2 {} m: "
    "it is from an earlier flight, or its start is not in the time of mocap"
)


def plan(start: float) -> SampledPreview:
    """Return the preview of a plan in which both vehicles fly along x."""
    return sampled_preview(NAMES, (ALONG_X, ALONG_X), start)


def setpoint(t: float, *x: float) -> SwarmSetpoint:
    """Return setpoints at these places along x [m]."""
    still = swarm(NAMES, t)[1]
    return replace(still, pos=np.array([[one, 0.0, 0.0] for one in x]))


def reported(start: float, *setpoints: SwarmSetpoint) -> list[tuple[str, bool]]:
    """Return what is reported of a plan with each setpoint after it."""
    monitor = PlanMismatchMonitor()
    monitor.take_plan(plan(start))
    return [monitor.update(one) for one in setpoints]


@pytest.mark.parametrize(("t", "x"), [(8.0, 0.0), (10.0, 0.0), (12.0, 2.0), (14.0, 4.0), (14.99, 4.0)])
def test_a_plan_fits_the_setpoints_that_come_from_it(t: float, x: float) -> None:
    moved = setpoint(t, x + 0.99, x)  # by a replanner
    assert reported(10.0, setpoint(t, x, x)) == reported(10.0, moved) == [("", False)]


def test_a_plan_of_another_place_is_reported_with_the_vehicles_that_are_far_from_it() -> None:
    assert reported(10.0, setpoint(12.0, 2.0, -3.0)) == [(FAR.format("5.0"), True)]
    stranger = replace(setpoint(12.0, 2.0, -3.0), names=("cf1", "cf9"))
    assert far_from_plan(plan(10.0), stranger) == ""  # reported elsewhere: the plan does not have it


def test_only_the_first_setpoint_after_a_plan_that_runs_is_compared_with_it() -> None:
    here, far = setpoint(12.0, 2.0, 2.0), setpoint(12.01, 2.0, 9.0)
    assert PlanMismatchMonitor().update(far) == ("", False)  # without a plan
    assert reported(10.0, here, far) == [("", False), ("", False)]


def test_a_plan_of_another_place_is_reported_until_the_setpoints_come_to_it_and_once_as_new() -> None:
    course = [setpoint(12.0, 2.0, 7.0), setpoint(12.5, 2.5, 5.0), setpoint(13.0, 3.0, 3.9)]
    first = FAR.format("5.0")
    later = setpoint(13.5, 3.5, 9.0)  # moved by a replanner
    assert reported(10.0, *course, later) == [(first, True), (first, False), ("", False), ("", False)]


def test_setpoints_that_hold_where_a_plan_ended_before_it_came_are_fine() -> None:
    """As for a controller that starts long after the end of the plan, which is latched."""
    hold = [setpoint(t, 4.0, 4.5) for t in (15.5, 60.0, 600.0)]
    assert reported(10.0, *hold) == [("", False)] * 3


def test_a_plan_that_was_over_when_it_came_is_reported_while_the_setpoints_are_elsewhere() -> None:
    course = [setpoint(15.5, 4.0, 4.0), setpoint(17.0, 4.0, 5.0), setpoint(19.0, 4.0, 9.0)]
    first = OVER.format("1.5", "1.0")
    assert reported(10.0, *course) == [("", False), (first, True), (first, False)]
    back, again = setpoint(20.0, 4.0, 4.0), setpoint(21.0, 4.0, 6.0)
    assert reported(10.0, *course, back, again)[3:] == [("", False), (OVER.format("1.5", "2.0"), False)]


@pytest.mark.parametrize(("start", "t"), [(0.0, 1.7e9), (1.7e9, 50.0)])
def test_a_plan_of_another_time_base_is_reported_though_the_setpoints_stay_at_its_end(
    start: float, t: float
) -> None:
    place = 4.0 if start < t else 0.0
    first = (
        f"plan: starts at {start:.0f} s, but the setpoints are at {t:.0f} s: "
        "check that their nodes use one clock"
    )
    still = [setpoint(t + 0.01 * tick, place, place) for tick in range(3)]
    assert reported(start, *still) == [(first, True), (first, False), (first, False)]


def test_the_next_plan_is_reported_anew() -> None:
    monitor, elsewhere = PlanMismatchMonitor(), setpoint(12.0, 2.0, -3.0)
    for _ in range(2):
        monitor.take_plan(plan(10.0))
        assert [monitor.update(elsewhere)[1] for _ in range(2)] == [True, False]
