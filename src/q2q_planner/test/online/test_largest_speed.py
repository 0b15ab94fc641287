"""With bounded jerk no setpoint is faster than the largest speed, whatever the other bounds are."""

import numpy as np
import pytest
from resting_signals import resting_setpoint

from q2q_model.signals.values import Array, SetpointStatus, SwarmSetpoint
from q2q_planner.online.safe.motion.safe_replanner_params import SafeReplannerParams
from q2q_planner.online.safe.safe_replanner import SafeReplanner

TICK = 0.01
NAMES = ("cf0",)
MOVING = 400
"""Ticks for which the reference moves."""


def flown_alone(seed: int, params: SafeReplannerParams, ticks: int) -> tuple[list[SwarmSetpoint], Array]:
    """Return the setpoints of one vehicle, and where its reference is in the end.

    The reference heads for a new point every second, by steps of its acceleration or within the largest
    jerk; after MOVING ticks it rests. One tick in ten is lost.
    """
    draw = np.random.default_rng(seed)
    pos, goal = draw.uniform(-6.0, 6.0, (2, 1, 3))
    vel, acc, t = np.zeros((1, 3)), np.zeros((1, 3)), 0.0
    most, step = params.acc_max / np.sqrt(3.0), draw.choice([0.9 * params.jerk_max * TICK, np.inf])
    replanner, flown = SafeReplanner(params), []
    for k in range(ticks):
        if k < MOVING:
            goal = draw.uniform(-6.0, 6.0, (1, 3)) if k % 100 == 50 else goal
            want = np.clip(4.0 * (goal - pos) - 3.0 * vel, -most, most)
            acc = acc + np.clip(want - acc, -step, step)
        else:
            vel, acc = np.zeros((1, 3)), np.zeros((1, 3))
        flown.append(replanner.update(resting_setpoint(t, NAMES, pos, vel=vel, acc=acc), None))
        dt = TICK if draw.random() < 0.9 else 2.0 * TICK
        pos, vel, t = pos + dt * vel + 0.5 * dt**2 * acc, vel + dt * acc, t + dt
    return flown, pos


@pytest.mark.parametrize("speed_max", [1.0, 2.0, 2.5])
@pytest.mark.parametrize("jerk_max", [5.0, 10.0, 20.0, 50.0])
@pytest.mark.parametrize("acc_max", [2.0, 3.0, 4.0, 5.0])
def test_a_vehicle_alone_keeps_every_bound(acc_max: float, jerk_max: float, speed_max: float) -> None:
    params = SafeReplannerParams(acc_max=acc_max, jerk_max=jerk_max, speed_max=speed_max)
    flown, _ = flown_alone(int(10.0 * speed_max), params, MOVING)
    assert max(float(np.linalg.norm(one.vel)) for one in flown) <= speed_max
    assert not any((one.status == SetpointStatus.PROMISE_BROKEN).any() for one in flown)
    assert max(float(np.abs(one.acc).max()) for one in flown) <= acc_max * (1.0 + 1e-9)


@pytest.mark.parametrize(("acc_max", "jerk_max"), [(5.0, 5.0), (4.0, 10.0), (2.0, 20.0), (5.0, 50.0)])
def test_a_vehicle_returns_however_slowly_it_must(acc_max: float, jerk_max: float) -> None:
    """At half of the largest speed at least: 12 s later nine tenths of the way are behind it."""
    params = SafeReplannerParams(acc_max=acc_max, jerk_max=jerk_max, speed_max=1.0, height_min=-100.0)
    flown, end = flown_alone(0, params, 1600)
    there, then = (np.linalg.norm(flown[k].pos - end) for k in (-1, MOVING))
    assert then > 3.0
    assert there < 0.1 * then
