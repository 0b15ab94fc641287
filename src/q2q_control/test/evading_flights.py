"""Vehicles at rest of which some are lost: states, setpoints and fallbacks for tests of the evasion."""

import numpy as np
from resting_signals import resting_setpoint, resting_state

from q2q_control.failsafe.evasion.climb_back import InFallback
from q2q_control.failsafe.tracking_loss.dead_reckoned_braking import levels_or_lands
from q2q_model.signals.values import CommandStatus, SwarmSetpoint, SwarmState

TICK = 0.01
UPPER = (0.0, 0.0, 1.5)
"""Of the vehicle that is lost [m]."""


def state_of(pos: np.ndarray) -> SwarmState:
    n = len(pos)
    return resting_state(0.0, names_of(n), pos)


def setpoint_of(t: float, pos: np.ndarray, vel: np.ndarray | None = None) -> SwarmSetpoint:
    n = len(pos)
    zero = np.zeros((n, 3))
    return resting_setpoint(t, names_of(n), pos, vel=zero if vel is None else vel)


def flown(n: int, *lost: int, how: CommandStatus = CommandStatus.LEVEL) -> InFallback:
    """Return the vehicles in fallback if the last tick's command has this status for these rows."""
    status = np.full(n, CommandStatus.OK, dtype=np.uint8)
    status[list(lost)] = how
    level, cut = levels_or_lands(status), status == CommandStatus.CUT
    return InFallback(*(tuple(names_of(n)[row] for row in np.flatnonzero(rows)) for rows in (level, cut)))


def names_of(n: int) -> tuple[str, ...]:
    return tuple(f"cf{k + 1}" for k in range(n))
