"""Lead vehicles that are measured again far from their setpoints back to these, as fast as tilt allows.

A vehicle without measurements stops, and its setpoint goes on. A step of metres would saturate its tilt, and
so would one to the velocity of the plan: it would overshoot. Its setpoint therefore begins where it is
measured, with its velocity but for what leads further away, which it brakes first, and joins that of the plan
in the least time in which the shift (q2q_control.inputs.shifted_setpoint) accelerates by at most A, with a
jerk of at most J:

    A T^2 >= PEAK |p0| + PEAK_V |v0| T                      flown: r + s with its velocity and acceleration
    J T^3 >= 60 |p0| + 36 |v0| T                            the quintic's jerk as it begins, its largest

A replanner does the same in space, and its setpoint is where the vehicle is.

| symbol | name | meaning [unit] |
|---|---|---|
| p0, v0 | pos, vel | shift and its velocity at the beginning [m], [m/s], (2,) |
| T | duration | time until the setpoint is that of the plan [s] |
| A, J | ACC_MAX, JERK_MAX | largest acceleration [m/s^2] and jerk [m/s^3] |
"""

import math
from dataclasses import fields, replace

import numpy as np

from q2q_control.inputs.alignment import LARGEST_VALUE
from q2q_control.inputs.shifted_setpoint import QuinticShift, ShiftedSetpoint
from q2q_model.signals.values import SwarmSetpoint, SwarmState

FAR = 0.5
"""Distance from which a vehicle is led back [m]: a step of less does not saturate the tilt for long."""
ACC_MAX = 2.75
"""Largest acceleration [m/s^2]: three quarters of that of TILT_MAX (q2q_model.vehicle.attitude_limits) at
hover thrust, as one that ends its climb has less for a second."""
JERK_MAX = 10.0
"""Largest jerk [m/s^3]: thrust turns some 0.2 s after it is asked to, and what is missing by then has to be
caught up (docs/reliability.md): 95 % of random losses then stay within 0.30 m, without this bound 0.50 m."""
PEAK = 10.0 / 3.0**0.5
"""Peak acceleration of the quintic from rest, times T^2 over the distance [-]."""
PEAK_V = 3.95
"""Peak acceleration of the quintic that stops v0, times T over the velocity [-]: u = 0.243."""


class Rejoining:
    """Vehicles on their way back to their setpoints."""

    def __init__(self) -> None:
        self._away: frozenset[str] = frozenset()
        self._shifts: dict[str, QuinticShift] = {}

    @property
    def active(self) -> bool:
        """Return whether any vehicle is away, or on its way back."""
        return bool(self._away or self._shifts)

    def update(self, setpoint: SwarmSetpoint, state: SwarmState, away: frozenset[str]) -> SwarmSetpoint:
        """Return the setpoints to fly.

        Args:
            setpoint: of the tick.
            state: of the tick.
            away: vehicles that do not follow their setpoints: lost ones, and those that climb back.
        """
        t, back = setpoint.t, self._away.difference(away).intersection(setpoint.names, state.names)
        self._away = away
        kept = {name: one for name, one in self._shifts.items() if name not in away and not one.over(t)}
        self._shifts = kept | {name: one for name in back if (one := _begun(setpoint, state, name))}
        return _shifted(setpoint, self._shifts)


def _begun(setpoint: SwarmSetpoint, state: SwarmState, name: str) -> QuinticShift | None:
    """Return the shift from where a vehicle is measured; None if its setpoint is near, or not plausible."""
    row, mine = setpoint.names.index(name), state.names.index(name)
    pos = state.pos[mine, :2] - setpoint.pos[row, :2]
    far, own = float(np.hypot(*pos)), state.vel[mine, :2]
    if not FAR < far < LARGEST_VALUE:
        return None
    vel = own - max(float(own @ pos), 0.0) / far**2 * pos - setpoint.vel[row, :2]
    fast = float(np.hypot(*vel))
    if not fast < LARGEST_VALUE:
        return None
    return QuinticShift(setpoint.t, _least_time(far, fast), pos, vel)


def _least_time(far: float, fast: float) -> float:
    """Return the time [s] to stop at a distance [m] from a velocity [m/s] within ACC_MAX and JERK_MAX."""
    half = 0.5 * PEAK_V * fast / ACC_MAX
    accelerating = half + math.sqrt(half * half + PEAK * far / ACC_MAX)
    turning = np.roots((JERK_MAX, 0.0, -36.0 * fast, -60.0 * far)).real.max()  # the only positive root
    return max(accelerating, float(turning))


def _shifted(setpoint: SwarmSetpoint, shifts: dict[str, QuinticShift]) -> SwarmSetpoint:
    """Return the setpoints with the shifts of those that are among them added."""
    flown = {name: shift for name, shift in shifts.items() if name in setpoint.names}
    if not flown:
        return setpoint
    given = {field.name: getattr(setpoint, field.name) for field in fields(SwarmSetpoint)}
    shifted = ShiftedSetpoint(**given, shifts=flown)
    moved = shifted.shift_at(np.array([setpoint.t]))[:, 0]
    pos, vel, acc = setpoint.pos + moved[:, :3], setpoint.vel + moved[:, 3:6], setpoint.acc + moved[:, 6:]
    return replace(shifted, pos=pos, vel=vel, acc=acc)
