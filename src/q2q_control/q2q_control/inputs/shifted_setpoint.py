"""Setpoints that are shifted from their plan by known motions, which end on it.

    s(t) = p0 (1 - 10 u^3 + 15 u^4 - 6 u^5) + v0 T (u - 6 u^3 + 8 u^4 - 3 u^5)      u = t / T

A predictive controller has the plan ahead (q2q_control.inputs.preview) and needs the shift ahead, too: from
the setpoint of one tick it cannot know that a fast one is about to brake.

| symbol | name | meaning [unit] |
|---|---|---|
| s | shift | horizontal shift of a setpoint [m], (2,) |
| p0, v0 | pos, vel | shift and its velocity at the beginning [m], [m/s], (2,) |
| T | duration | time until the setpoint is that of the plan [s] |
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from q2q_model.signals.values import Array, SwarmSetpoint


class QuinticShift(NamedTuple):
    """Shift of one setpoint, which begins at a position with a velocity and ends at rest, at 0."""

    since: float
    """Tick at which it began [s]."""
    duration: float
    """[s]"""
    pos: Array
    """[m], (2,)"""
    vel: Array
    """[m/s], (2,)"""

    def over(self, t: float) -> bool:
        """Return whether it has ended by the tick t [s]."""
        return t - self.since >= self.duration

    def at(self, times: Array) -> Array:
        """Return position [m], velocity and acceleration of the shift along x and y at `times` (K,) [s].

        Before its beginning, as where the clock was set back, it is that of its beginning; (K, 3, 2).
        """
        duration, p, v = self.duration, self.pos, self.vel * self.duration
        u = np.clip((times - self.since) / duration, 0.0, 1.0)[:, None]
        cubic, quartic, quintic = -10.0 * p - 6.0 * v, 15.0 * p + 8.0 * v, -6.0 * p - 3.0 * v
        shift = p + u * v + u**3 * (cubic + u * (quartic + u * quintic))
        rate = v + u**2 * (3.0 * cubic + u * (4.0 * quartic + u * 5.0 * quintic))
        bend = u * (6.0 * cubic + u * (12.0 * quartic + u * 20.0 * quintic))
        return np.stack((shift, rate / duration, bend / duration**2), axis=1)


@dataclass(frozen=True, slots=True)
class ShiftedSetpoint(SwarmSetpoint):
    """Setpoints of all vehicles, with the shifts that are in them."""

    shifts: Mapping[str, QuinticShift]
    """By name; vehicles without one are not shifted, or nobody knows for how long."""

    def shift_at(self, times: Array) -> Array:
        """Return position [m], velocity, acceleration of all shifts at `times` (K,) [s], (n, K, 9)."""
        moved = np.zeros((len(self.names), times.size, 3, 3))
        for row, name in enumerate(self.names):
            if name in self.shifts:
                moved[row, :, :, :2] = self.shifts[name].at(times)
        return moved.reshape(len(self.names), times.size, 9)
