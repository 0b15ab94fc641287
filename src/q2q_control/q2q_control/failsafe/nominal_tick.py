"""Nominal tick of the guard, compiled: every vehicle is measured, commanded and on. Nearly every tick is."""

from math import isfinite

import numpy as np
from numpy.typing import NDArray

from q2q_control.failsafe.blind_flight.dead_reckoning import TRACKED
from q2q_model.compiled import compiled
from q2q_model.signals.values import Array, CommandStatus, Status

SOUND = int(CommandStatus.SATURATED)
"""Highest status of a command computed from a usable state."""
Given = tuple[Array, Status, Array, Status]
"""Ages of the measurements in a state [s], (n,), and their TrackStatus, (n,); thrust, roll, pitch and yaw
rate of a command, which must be finite, (4 n,), and its CommandStatus, (n,)."""


@compiled
def note_nominal(
    times: tuple[float, float, float],
    given: Given,
    memory: tuple[NDArray[np.bool_], Array],
) -> bool:
    """Return whether a tick is nominal; if it is, write when each vehicle was measured.

    Args:
        times: Tick, time since the state's, and largest nominal age of a measurement [s].
        given: State and command of the tick.
        memory: Motors cut, (n,), and `b` of q2q_control.failsafe.guard [s], (n,).
    """
    (t, known, most), (age, track, values, status) = times, given
    down, measured_at = memory
    for i in range(age.size):
        if not (known <= age[i] + known < most) or track[i] != TRACKED:
            return False
        if status[i] > SOUND or down[i]:
            return False
    for value in values:
        if not isfinite(value):
            return False
    for i in range(age.size):
        measured_at[i] = t - age[i] - max(known, 0.0)
    return True
