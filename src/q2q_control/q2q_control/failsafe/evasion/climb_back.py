"""Let vehicles that are measured again return to the heights of their setpoints before they follow these.

A vehicle that was lost has left the height of its plan, and its setpoint may be elsewhere by then, beyond
vehicles that the plan passes above or below. It climbs, or sinks, where it is measured again, until it is
within BACK of its setpoint's height, for LONGEST at most: a weak one may never get there. From there it is
led back to its setpoint (q2q_control.failsafe.evasion.rejoining).

A replanner begins at a vehicle that it finds again, and the setpoint climbs with that. Vehicles below a
returning one evade it (q2q_control.failsafe.evasion.descent_evasion) until its setpoint is steady, too:

    |r_z'| + |r_z''| B < v_b

| symbol | name | meaning [unit] |
|---|---|---|
| r | setpoint | position of a setpoint [m], (3,) |
| v_b, B | STEADY, STEADY_S | velocity [m/s] and time [s] of a steady height |
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from q2q_control.failsafe.evasion.rejoining import Rejoining
from q2q_model.signals.values import Array, Names, SwarmSetpoint, SwarmState, rows_by_name

BACK = 0.3
"""Height difference from its setpoint within which a vehicle measured again is back [m]."""
STEADY = 0.5
"""Vertical velocity of a setpoint at its height [m/s]: as it stops within STEADY_S, half of BACK is left."""
STEADY_S = 0.5
"""Time in which its acceleration counts [s]: a setpoint that turns from sinking to climbing is not there."""
LONGEST = 3.5
"""Longest climb [s]: 2 m at 0.8 m/s and a second to turn, the time after which policies expect it back."""


class InFallback(NamedTuple):
    """Vehicles in fallback phases."""

    lost: Names
    """Not measured any longer: their commands are LEVEL or LAND, or soon will be."""
    cut: Names
    """Their motors are off for good."""


class Returning(NamedTuple):
    """Vehicles measured again that are not yet back."""

    setpoint: SwarmSetpoint
    """Of all vehicles."""
    names: frozenset[str]


class ClimbBack:
    """Vehicles that were lost and are not yet back at their setpoints."""

    def __init__(self) -> None:
        self._gone: set[str] = set()
        self._since: dict[str, float] = {}  # tick at which each was measured again [s]
        self._places: dict[str, Array] = {}  # where each climbs [m], (2,)
        self._rejoining = Rejoining()

    @property
    def active(self) -> bool:
        """Return whether any vehicle is not yet back."""
        return bool(self._gone) or self._rejoining.active

    def update(self, setpoint: SwarmSetpoint, state: SwarmState, fallback: InFallback) -> Returning:
        """Return who is returning, and setpoints with which these climb where they are.

        Args:
            setpoint: of the tick.
            state: of the tick.
            fallback: vehicles without measurements, and cut ones.
        """
        seen = self._gone.difference(fallback.lost, fallback.cut)
        off = seen.intersection(_off_height(setpoint, state))
        returning = off | seen.intersection(_moving_vertically(setpoint), state.names)
        self._since = {name: self._since.get(name, setpoint.t) for name in returning}
        returning = {name for name in returning if setpoint.t - self._since[name] <= LONGEST}
        self._gone = returning.union(fallback.lost)
        self._places = {
            name: self._places.get(name, state.pos[state.names.index(name), :2].copy())
            for name in sorted(off & returning)
        }
        away = frozenset(self._places).union(fallback.lost)
        led = self._rejoining.update(_held_at(setpoint, self._places), state, away)
        return Returning(led, frozenset(returning))


def _held_at(setpoint: SwarmSetpoint, places: dict[str, Array]) -> SwarmSetpoint:
    """Return the setpoints with vehicles held at horizontal places [m], (2,) each."""
    if not places:
        return setpoint
    pos, vel, acc = setpoint.pos.copy(), setpoint.vel.copy(), setpoint.acc.copy()
    for name, place in places.items():
        row = setpoint.names.index(name)
        pos[row, :2], vel[row, :2], acc[row, :2] = place, 0.0, 0.0
    return replace(setpoint, pos=pos, vel=vel, acc=acc)


def _off_height(setpoint: SwarmSetpoint, state: SwarmState) -> Names:
    """Return the vehicles further than BACK from the heights of their setpoints."""
    height = rows_by_name(state.pos[:, 2], state.names, setpoint.names, np.nan)
    return _named(setpoint, np.abs(height - setpoint.pos[:, 2]) > BACK)


def _moving_vertically(setpoint: SwarmSetpoint) -> Names:
    """Return the vehicles whose setpoints climb or sink, or soon will."""
    fast = np.abs(setpoint.vel[:, 2]) + STEADY_S * np.abs(setpoint.acc[:, 2]) >= STEADY
    return _named(setpoint, fast)


def _named(setpoint: SwarmSetpoint, rows: NDArray[np.bool_]) -> Names:
    return tuple(setpoint.names[row] for row in np.flatnonzero(rows))
