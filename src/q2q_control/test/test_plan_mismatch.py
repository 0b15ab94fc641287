"""A plan that is not that of the setpoints is told, by its time and by its place, with the first setpoint."""

from dataclasses import replace

import numpy as np
import pytest
from pid_swarms import swarm

from q2q_control.inputs.plan_mismatch import PlanMismatchMonitor, plan_mismatch
from q2q_control.inputs.plan_samples import sampled_preview
from q2q_control.inputs.preview import SampledPreview
from q2q_model.signals.values import SwarmSetpoint
from q2q_model.trajectory.polynomials import Trajectory

NAMES = ("cf1", "cf2")
ALONG_X = Trajectory(np.array([4.0]), np.array([[[0.0, 1.0], [0.0, 0.0], [0.0, 0.0], [0.0, 0.0]]]))
"""4 s at 1 m/s."""


def plan(start: float) -> SampledPreview:
    """Return the preview of a plan in which both vehicles fly along x."""
    return sampled_preview(NAMES, (ALONG_X, ALONG_X), start)


def setpoint(t: float, *x: float) -> SwarmSetpoint:
    """Return setpoints at these places along x [m]."""
    still = swarm(NAMES, t)[1]
    return replace(still, pos=np.array([[one, 0.0, 0.0] for one in x]))


@pytest.mark.parametrize(("t", "x"), [(8.0, 0.0), (10.0, 0.0), (12.0, 2.0), (14.0, 4.0), (14.99, 4.0)])
def test_a_plan_fits_the_setpoints_that_come_from_it(t: float, x: float) -> None:
    assert plan_mismatch(plan(10.0), setpoint(t, x, x)) == ""
    assert plan_mismatch(plan(10.0), setpoint(t, x + 0.99, x)) == ""  # moved by a replanner


def test_a_plan_that_is_over_when_it_comes_is_told() -> None:
    told = "plan: it ended 1.5 s before it came: does it start by the stamps of mocap?"
    assert plan_mismatch(plan(10.0), setpoint(15.5, 4.0, 4.0)) == told


def test_a_plan_of_another_place_is_told_with_the_vehicles_that_are_far_from_it() -> None:
    told = "plan: it is far from the setpoints: cf2 5.0 m: is it the plan they come from?"
    assert plan_mismatch(plan(10.0), setpoint(12.0, 2.0, -3.0)) == told
    stranger = replace(setpoint(12.0, 2.0, -3.0), names=("cf1", "cf9"))
    assert plan_mismatch(plan(10.0), stranger) == ""  # told elsewhere: the plan does not have it


def test_only_the_first_setpoint_after_a_plan_is_compared_with_it() -> None:
    monitor, here, far = PlanMismatchMonitor(), setpoint(12.0, 2.0, 2.0), setpoint(12.01, 2.0, 9.0)
    assert monitor.look(far) == ""  # without a plan
    monitor.take_plan(plan(10.0))
    assert [monitor.look(one) for one in (here, far)] == ["", ""]
    monitor.take_plan(plan(10.0))
    assert [bool(monitor.look(one)) for one in (far, far)] == [True, False]
