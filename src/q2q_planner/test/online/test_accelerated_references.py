"""Without bounded jerk a reference may accelerate at any rate, and the promise still holds."""

import numpy as np
import pytest
from resting_signals import resting_setpoint

from q2q_model.geometry.zone import Cylinder
from q2q_model.signals.values import Array, SetpointStatus, SwarmSetpoint
from q2q_planner.online.safe.motion.safe_replanner_params import SafeReplannerParams
from q2q_planner.online.safe.safe_replanner import SafeReplanner
from q2q_planner.online.setpoint_error import SHIFT_TOLERANCE

TICK = 0.01
TICKS = 150
BROKEN = SetpointStatus.PROMISE_BROKEN


def reference(t: float, pos: Array, vel: Array, acc: Array) -> SwarmSetpoint:
    return resting_setpoint(t, tuple(f"cf{row}" for row in range(len(pos))), pos, vel=vel, acc=acc)


def flight_to_the_middle(seed: int) -> tuple[SafeReplannerParams, list[SwarmSetpoint], list[SwarmSetpoint]]:
    """Return parameters, references and setpoints of 2 to 4 vehicles that start at rest on a ring.

    Their references accelerate towards its middle, at up to 30 m/s^2. One tick in ten is lost.
    """
    draw = np.random.default_rng(seed)
    count, acc_max = int(draw.integers(2, 5)), draw.uniform(1.0, 6.0)
    params = SafeReplannerParams(
        acc_max=acc_max, approach=draw.uniform(1.0, 10.0), hold=draw.choice([0.02, 0.03])
    )
    turn = 2.0 * np.pi * (draw.uniform() + np.arange(count) / count)
    pos = draw.uniform(1.0, 12.0) * np.stack([np.cos(turn), np.sin(turn), np.zeros(count)], axis=1)
    way = draw.normal(scale=0.1, size=(count, 3)) * (1.0, 1.0, 0.0) - pos
    acc = min(draw.uniform(1.5, 6.0) * acc_max, 30.0) * way / np.linalg.norm(way, axis=1, keepdims=True)
    replanner, vel, t = SafeReplanner(params), np.zeros_like(pos), 0.0
    given, flown = [], []
    for _ in range(TICKS):
        given.append(reference(t, pos, vel, acc))
        flown.append(replanner.update(given[-1], None))
        dt = TICK if draw.random() < 0.9 else 2.0 * TICK
        pos, vel, t = pos + dt * vel + 0.5 * dt**2 * acc, vel + dt * acc, t + dt
    return params, given, flown


@pytest.mark.parametrize("seed", range(20, 50))
def test_no_acceleration_of_a_reference_breaks_the_promise(seed: int) -> None:
    params, given, flown = flight_to_the_middle(seed)
    assert not any((one.status == BROKEN).any() for one in flown)
    pos, acc = np.array([one.pos for one in flown]), np.array([one.acc for one in flown])
    i, j = np.triu_indices(pos.shape[1], 1)
    zone = Cylinder(params.eps + 2.0 * params.tracking, params.d + 2.0 * params.tracking)
    assert zone.signed_distance(pos[:, i] - pos[:, j]).min() > 0.0
    shifted = np.linalg.norm(pos - np.array([one.pos for one in given]), axis=-1) > SHIFT_TOLERANCE
    assert shifted.any()
    assert np.linalg.norm(acc, axis=-1)[shifted].max() <= params.acc_max * (1.0 + 1e-12)
