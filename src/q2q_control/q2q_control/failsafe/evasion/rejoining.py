"""Lead vehicles that are measured again far from their setpoints back to these, as fast as tilt allows.

A vehicle without measurements stops, and its setpoint goes on. A step of metres would saturate its tilt, and
it would overshoot. Its setpoint therefore begins where it is measured, with its velocity unless that leads
further away, and joins that of the plan in the least time in which the shift accelerates by at most A:

    s(t) = p0 (1 - 10 u^3 + 15 u^4 - 6 u^5) + v0 T (u - 6 u^3 + 8 u^4 - 3 u^5)      u = t / T
    A T^2 = PEAK |p0| + PEAK_V |v0| T                       flown: r + s with its velocity and acceleration

A replanner does the same in space, and its setpoint is where the vehicle is.

| symbol | name | meaning [unit] |
|---|---|---|
| s | shift | horizontal shift of a setpoint [m], (2,) |
| p0, v0 | pos, vel | shift and its velocity at the beginning [m], [m/s], (2,) |
| T | duration | time until the setpoint is that of the plan [s] |
| A | ACC | largest acceleration [m/s^2] |
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from q2q_model.signals.values import Array, SwarmSetpoint, SwarmState

FAR = 0.5
"""Distance from which a vehicle is led back [m]: a step of less does not saturate the tilt for long."""
ACC = 2.5
"""Largest acceleration [m/s^2]: three quarters of that of 0.35 rad, controllers' largest tilt, at hover
thrust, as one that ends its climb has less for a second."""
PEAK = 10.0 / 3.0**0.5
"""Peak acceleration of the quintic from rest, times T^2 over the distance [-]."""
PEAK_V = 3.95
"""Peak acceleration of the quintic that stops v0, times T over the velocity [-]: u = 0.243."""


class _Shift(NamedTuple):
    """Quintic shift of one setpoint."""

    since: float
    """Tick at which it began [s]."""
    duration: float
    pos: Array
    vel: Array

    def over(self, t: float) -> bool:
        """Return whether it has ended by the tick t [s]."""
        return t - self.since >= self.duration

    def at(self, t: float) -> tuple[Array, Array, Array]:
        """Return shift [m], velocity [m/s] and acceleration [m/s^2] at the tick t [s], (2,) each.

        Where the clock was set back, it begins again.
        """
        duration, p, v = self.duration, self.pos, self.vel * self.duration
        u = max(t - self.since, 0.0) / duration
        cubic, quartic, quintic = -10.0 * p - 6.0 * v, 15.0 * p + 8.0 * v, -6.0 * p - 3.0 * v
        shift = p + u * v + u**3 * (cubic + u * (quartic + u * quintic))
        rate = v + u**2 * (3.0 * cubic + u * (4.0 * quartic + u * 5.0 * quintic))
        bend = u * (6.0 * cubic + u * (12.0 * quartic + u * 20.0 * quintic))
        return shift, rate / duration, bend / duration**2


class Rejoining:
    """Vehicles on their way back to their setpoints."""

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget all of them."""
        self._away: frozenset[str] = frozenset()
        self._shifts: dict[str, _Shift] = {}

    @property
    def active(self) -> bool:
        """Return whether any vehicle is away, or on its way back."""
        return bool(self._away or self._shifts)

    def update(self, setpoint: SwarmSetpoint, state: SwarmState, away: frozenset[str]) -> SwarmSetpoint:
        """Return the setpoints to fly.

        Args:
            setpoint: of the tick.
            state: of the tick.
            away: vehicles that do not follow their setpoints: blind ones, and those that climb back.
        """
        t, back = setpoint.t, self._away.difference(away).intersection(setpoint.names, state.names)
        self._away = away
        kept = {name: one for name, one in self._shifts.items() if name not in away and not one.over(t)}
        self._shifts = kept | {name: one for name in back if (one := _begun(setpoint, state, name))}
        return _shifted(setpoint, self._shifts)


def _begun(setpoint: SwarmSetpoint, state: SwarmState, name: str) -> _Shift | None:
    """Return the shift that begins where a vehicle is measured; None if that is near its setpoint."""
    row, mine = setpoint.names.index(name), state.names.index(name)
    pos = state.pos[mine, :2] - setpoint.pos[row, :2]
    vel = state.vel[mine, :2] - setpoint.vel[row, :2]
    far = float(np.hypot(*pos))
    if not far > FAR:
        return None
    vel = vel - max(float(vel @ pos), 0.0) / far**2 * pos
    half = 0.5 * PEAK_V * float(np.hypot(*vel)) / ACC
    return _Shift(setpoint.t, half + (half * half + PEAK * far / ACC) ** 0.5, pos, vel)


def _shifted(setpoint: SwarmSetpoint, shifts: dict[str, _Shift]) -> SwarmSetpoint:
    rows = {name: setpoint.names.index(name) for name in shifts if name in setpoint.names}
    if not rows:
        return setpoint
    pos, vel, acc = setpoint.pos.copy(), setpoint.vel.copy(), setpoint.acc.copy()
    for name, row in rows.items():
        for values, moved in zip((pos, vel, acc), shifts[name].at(setpoint.t), strict=True):
            values[row, :2] += moved
    return replace(setpoint, pos=pos, vel=vel, acc=acc)
