"""Signals of vehicles that rest level and are tracked, for tests; keywords replace other fields."""

from dataclasses import replace

import numpy as np

from q2q_model.geometry.rotations import identity_quat
from q2q_model.signals.values import Array, Names, Status, SwarmCommand, SwarmSetpoint, SwarmState


def resting_state(t: float, names: Names, pos: Array, **changed: Array | Status) -> SwarmState:
    """Return the state of vehicles that rest at pos [m], world, (n, 3)."""
    n = len(names)
    vel, ang_vel_body, sound = np.zeros((n, 3)), np.zeros((n, 3)), np.zeros(n, np.uint8)
    return replace(
        SwarmState(t, names, pos, vel, identity_quat((n,)), ang_vel_body, np.zeros(n), sound), **changed
    )


def resting_setpoint(t: float, names: Names, pos: Array, **changed: Array | Status) -> SwarmSetpoint:
    """Return nominal setpoints at pos [m], world, (n, 3)."""
    n = len(names)
    vel, acc, sound = np.zeros((n, 3)), np.zeros((n, 3)), np.zeros(n, np.uint8)
    return replace(SwarmSetpoint(t, names, pos, vel, acc, np.zeros(n), np.zeros(n), sound), **changed)


def level_command(t: float, names: Names, thrust: Array, **changed: Array | Status) -> SwarmCommand:
    """Return commands of level attitude and a thrust [N], (n,)."""
    n = len(names)
    sound = np.zeros(n, np.uint8)
    return replace(SwarmCommand(t, names, thrust, np.zeros(n), np.zeros(n), np.zeros(n), sound), **changed)
