"""Vehicles and motions that the safe law is asked about."""

import numpy as np
from resting_signals import resting_setpoint

from q2q_model.signals.values import Array, Names, SwarmSetpoint, SwarmState
from q2q_planner.online.last_known_states import KnownStates
from q2q_planner.online.safe.motion.committed_motion import CommittedMotion, MotionRows
from q2q_planner.online.safe.motion.safe_replanner_params import SafeReplannerParams

PARAMS = SafeReplannerParams(
    eps=0.25, d=1.0, margin=0.02, acc_max=3.0, hold=0.02, approach=2.0, tracking=0.05, drift=0.2,
    speed_max=2.0, forget=2.0,
)  # fmt: skip
NOBODY = KnownStates((), np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0))
OFF, ON = np.zeros(2, np.bool_), np.ones(2, np.bool_)


def state(t: float, names: Names, x: list[float], age: float = 0.0, speed: float = 1.0) -> SwarmState:
    """Return vehicles at x [m] that fly along y."""
    n, zero = len(names), np.zeros((len(names), 3))
    pos, vel = zero.copy(), zero.copy()
    pos[:, 0], vel[:, 1] = x, speed
    return SwarmState(t, names, pos, vel, np.zeros((n, 4)), zero, np.full(n, age), np.zeros(n, np.uint8))


def setpoint(t: float, names: Names, pos: Array, vel: Array | None = None) -> SwarmSetpoint:
    zero = np.zeros((len(names), 3))
    vel = zero if vel is None else vel
    return resting_setpoint(t, names, pos, vel=vel)


def held(pos: Array, vel: Array, hold: float = 0.0, acc: Array | None = None) -> CommittedMotion:
    """Return two vehicles' motion from t = 1 s on, off their references."""
    acc = np.zeros((2, 3)) if acc is None else acc
    rows = MotionRows(pos, vel, acc, np.full(2, hold), OFF, OFF, np.zeros((2, 3)))
    return CommittedMotion(1.0, ("a", "b"), rows)
