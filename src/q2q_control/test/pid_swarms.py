"""Swarms that a PID is asked about: at rest on their setpoints, and anywhere."""

from dataclasses import replace

import numpy as np
from resting_signals import resting_setpoint, resting_state

from q2q_model.geometry.rotations import quat_from_euler
from q2q_model.signals.values import (
    Interference,
    Names,
    SwarmSetpoint,
    SwarmState,
)


def swarm(names: Names, t: float = 0.0) -> tuple[SwarmState, SwarmSetpoint, Interference]:
    """Return vehicles at rest, level, on their setpoints, in still air."""
    n = len(names)
    zero, flag = np.zeros((n, 3)), np.zeros(n, np.uint8)
    state = resting_state(t, names, zero)
    setpoint = resting_setpoint(t, names, zero)
    return state, setpoint, Interference(t, names, zero, zero, flag)


def random_swarm(
    seed: int, names: Names = ("cf1", "cf2", "cf3")
) -> tuple[SwarmState, SwarmSetpoint, Interference]:
    """Return vehicles anywhere, with any setpoints and downwash."""
    rng = np.random.default_rng(seed)
    state, setpoint, eta = swarm(names)
    n = len(names)
    attitude = quat_from_euler(*rng.uniform(-0.3, 0.3, (2, n)), rng.uniform(-3.0, 3.0, n))
    state = replace(state, pos=rng.normal(size=(n, 3)), vel=rng.normal(size=(n, 3)), quat=attitude)
    yaw, yaw_rate = rng.uniform(-3.0, 3.0, (2, n))
    ref = rng.normal(size=(3, n, 3))
    setpoint = replace(setpoint, pos=ref[0], vel=ref[1], acc=ref[2], yaw=yaw, yaw_rate=yaw_rate)
    return state, setpoint, replace(eta, acc=rng.normal(size=(n, 3)))
