"""Make way for a vehicle that nobody sees: who flies beneath it is moved aside before it comes down.

A vehicle that is level or lands blind (q2q_control.failsafe.ladder) drifts with the air and sinks to the
floor. Setpoints of vehicles that are seen, lie lower than it did, and are nearer than REACH to where it is
reckoned to be, p_j (q2q_control.failsafe.dead_reckoned_braking), are moved along u, the one of eight
directions, straight away from it first, that leads farthest from all others:

    wanted = max(0, REACH - (r - p_j) . u) u        r: setpoint; horizontal; u is kept until it is seen or cut
    s'' = w^2 (wanted - s) + 2 w (wanted' - s')   r + s, with its velocity and acceleration, is flown

| symbol | name | meaning [unit] |
|---|---|---|
| s | shift | how far a setpoint is moved [m], horizontal, (2,) |
| u | aside | unit vector, horizontal, (2,) |
| w | PACE | of the critically damped way there and back [rad/s] |
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from q2q_control.failsafe.ladder import is_blind
from q2q_model.signals.values import Array, Names, SwarmCommand, SwarmSetpoint, SwarmState

REACH = 0.6
"""How far aside is far enough [m]: two that touch, 0.14, and what air moves one in 2 s of blindness, 0.4."""
BENEATH = 0.1
"""Who is lower by less is beside the vehicle, not beneath it [m]: eps of the paper's zone."""
PACE = 3.0
"""80 % of the way in 1 s, the time from level to landing, by an acceleration of 5.4 m/s^2 at most."""
LONGEST_STEP = 0.1
"""A longer time between ticks counts as this [s]."""
AT_REST = 1e-3
"""A shift that is smaller is over [m]."""
DIRECTIONS = 8


@dataclass(slots=True)
class _Shift:
    """Shift of one vehicle's setpoint, and the vehicle it evades."""

    pos: Array = field(default_factory=lambda: np.zeros(2))
    vel: Array = field(default_factory=lambda: np.zeros(2))
    asides: dict[str, Array] = field(default_factory=dict)
    """Vehicle made way for -> u."""

    def follow(self, wanted: Array, wanted_vel: Array, dt: float) -> Array:
        """Move on by a time [s]; return the acceleration [m/s^2], (2,)."""
        acc = PACE**2 * (wanted - self.pos) + 2.0 * PACE * (wanted_vel - self.vel)
        self.vel = self.vel + acc * dt
        self.pos = self.pos + self.vel * dt
        return acc

    @property
    def over(self) -> bool:
        """Return whether the setpoint is where it was sent again, for good."""
        return not self.asides and float(np.abs(self.pos).max() + np.abs(self.vel).max()) < AT_REST


class DescentEvasion:
    """Evading vehicles and how far each has moved."""

    def __init__(self) -> None:
        """Nobody makes way."""
        self.reset()

    def reset(self) -> None:
        """Let everybody fly where it is sent."""
        self._shifts: dict[str, _Shift] = {}
        self._t: float | None = None

    @property
    def active(self) -> bool:
        """Return whether anybody makes way, or is on its way back."""
        return bool(self._shifts)

    def update(
        self, setpoint: SwarmSetpoint, state: SwarmState, flown: SwarmCommand, places: Mapping[str, Array]
    ) -> SwarmSetpoint:
        """Return the setpoints to fly.

        Args:
            setpoint: where vehicles are sent.
            state: a vehicle that is lost is as high as it was last believed.
            flown: the last tick's command: it says who is flown blind.
            places: where those are reckoned to be, horizontally [m], (2,) each.
        """
        dt = 0.0 if self._t is None else min(max(setpoint.t - self._t, 0.0), LONGEST_STEP)
        self._t = setpoint.t
        blind = tuple(flown.names[k] for k in np.flatnonzero(is_blind(flown.status)))
        if not blind and not self._shifts:
            return setpoint
        pos = state.pos.copy()
        for row, name in enumerate(state.names):
            if name in blind and name in places:
                pos[row, :2] = places[name]
        self._ask(blind, state.names, pos)
        moved = self._moved(setpoint, dict(zip(state.names, pos[:, :2], strict=True)), dt)
        self._shifts = {name: shift for name, shift in self._shifts.items() if not shift.over}
        return moved

    def _ask(self, blind: Names, names: Names, pos: Array) -> None:
        """Note who must make way for whom, and to which side."""
        known = set(blind) & set(names)
        for shift in self._shifts.values():
            shift.asides = {name: aside for name, aside in shift.asides.items() if name in known}
        gone = np.isin(names, blind)
        for j in np.flatnonzero(gone & np.isfinite(pos).all(axis=1)):
            for i in np.flatnonzero(~gone & _is_beneath(pos, pos[j])):
                shift = self._shifts.setdefault(names[i], _Shift())
                if names[j] not in shift.asides:
                    shift.asides[names[j]] = _aside(pos[:, :2], int(i), int(j))

    def _moved(self, setpoint: SwarmSetpoint, reckoned: Mapping[str, Array], dt: float) -> SwarmSetpoint:
        pos, vel, acc = setpoint.pos.copy(), setpoint.vel.copy(), setpoint.acc.copy()
        for row, name in enumerate(setpoint.names):
            shift = self._shifts.get(name)
            if shift is None:
                continue
            wanted, wanted_vel = np.zeros(2), np.zeros(2)
            for other, aside in shift.asides.items():
                lacking = REACH - float((setpoint.pos[row, :2] + wanted - reckoned[other]) @ aside)
                if lacking > 0.0:
                    wanted += lacking * aside
                    wanted_vel -= float((setpoint.vel[row, :2] + wanted_vel) @ aside) * aside
            acc[row, :2] += shift.follow(wanted, wanted_vel, dt)
            pos[row, :2] += shift.pos
            vel[row, :2] += shift.vel
        return replace(setpoint, pos=pos, vel=vel, acc=acc)


def _is_beneath(pos: Array, other: Array) -> NDArray[np.bool_]:
    """Return who flies beneath a place, near enough to be in the way, (n,)."""
    near = np.linalg.norm(pos[:, :2] - other[:2], axis=1) < REACH
    return np.asarray(near & (pos[:, 2] < other[2] - BENEATH))


def _aside(xy: Array, i: int, j: int) -> Array:
    """Return the direction in which vehicle i leaves j, (2,): away from it, or where others are farther."""
    away = np.arctan2(*(xy[i] - xy[j])[::-1])
    angles = away + np.arange(DIRECTIONS) * (2.0 * np.pi / DIRECTIONS)
    sides = np.stack([np.cos(angles), np.sin(angles)], axis=1)  # (8, 2)
    others = np.delete(xy, (i, j), axis=0)
    others = others[np.isfinite(others).all(axis=1)]
    room = np.linalg.norm(xy[j] + REACH * sides[:, None] - others, axis=2).min(axis=1, initial=REACH)
    return np.asarray(sides[int(room.argmax())])
