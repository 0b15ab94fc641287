"""Nominal tick of the guard, compiled: every vehicle is measured, commanded and on. Nearly every tick is."""

from math import isfinite
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from q2q_control.failsafe.blind_flight.dead_reckoning import TRACKED
from q2q_model.compiled import compiled
from q2q_model.signals.values import Array, CommandStatus, Status

SOUND = int(CommandStatus.SATURATED)
"""Highest status of a command computed from a usable state."""


class Given(NamedTuple):
    """Tick as the guard gets it."""

    age: Array
    """Of each measurement in the state [s], (n,)."""
    track: Status
    """TrackStatus, (n,)."""
    values: Array
    """Thrust, roll, pitch and yaw rate of the command, which must be finite, (4 n,)."""
    status: Status
    """CommandStatus, (n,)."""


class Memory(NamedTuple):
    """What the guard keeps of each vehicle."""

    down: NDArray[np.bool_]
    """Motors cut, (n,)."""
    measured_at: Array
    """`b` of q2q_control.failsafe.guard [s], (n,)."""


@compiled
def note_nominal(times: tuple[float, float, float], given: Given, memory: Memory) -> bool:
    """Return whether a tick is nominal; if it is, write when each vehicle was measured.

    Args:
        times: Tick, time since the state's, and largest nominal age of a measurement [s].
        given: Ages, tracks and command.
        memory: Of the guard.
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
