"""Nominal tick of the guard, compiled: every vehicle is measured, commanded and on. Nearly every tick is."""

from math import isfinite
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from q2q_model.compiled import compiled
from q2q_model.signals.values import SATURATED, TRACKED, Array, Status

SOUND = SATURATED
"""Highest status of a command computed from a usable state."""


class StateAndCommand(NamedTuple):
    """State and command of a tick."""

    age: Array
    """Of the measurements in the state [s], (n,)."""
    track: Status
    """TrackStatus, (n,)."""
    values: Array
    """Thrust, roll, pitch and yaw rate of the command, which must be finite, (4 n,)."""
    status: Status
    """CommandStatus, (n,)."""


class TickTimes(NamedTuple):
    """Times of a tick [s]."""

    t: float
    """Of the command."""
    state_delay: float
    """Since the state's."""
    age_max: float
    """Largest nominal age of a measurement."""


@compiled
def note_nominal(
    times: TickTimes,
    given: StateAndCommand,
    memory: tuple[NDArray[np.bool_], Array],
) -> bool:
    """Return whether a tick is nominal; if it is, write when each vehicle was measured.

    Args:
        times: of the tick, of its state, and of a measurement.
        given: state and command of the tick.
        memory: motors cut, (n,), and `b` of q2q_control.failsafe.guard [s], (n,).
    """
    (t, state_delay, age_max), (age, track, values, status) = times, given
    down, measured_at = memory
    for i in range(age.size):
        if not (state_delay <= age[i] + state_delay < age_max) or track[i] != TRACKED:
            return False
        if status[i] > SOUND or down[i]:
            return False
    for value in values:
        if not isfinite(value):
            return False
    for i in range(age.size):
        measured_at[i] = t - age[i] - max(state_delay, 0.0)
    return True
