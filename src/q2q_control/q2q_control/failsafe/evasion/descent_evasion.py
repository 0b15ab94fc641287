"""Move vehicles aside that fly below one without measurements, or little above it.

A vehicle that is lost, and soon levels or lands (q2q_control.failsafe.fallback_phases), drifts
with the wind and sinks to the floor; one lifted against a downwash that is no longer there rises at first.
Its position p_j is dead-reckoned (q2q_control.failsafe.tracking_loss). Where a measured vehicle or its
setpoint is within d_j of it horizontally, and less than RISE above it, the setpoint is shifted along u
(evasion_shift, evasion_direction): away from j if it is at rest, across its path if it moves or climbs back:

    d_j = REACH + DRIFT max(0, a_j - DRIFT_FROM_S)       at most FARTHEST

An evasion ends when j is cut, or measured again and back at the height of its setpoint
(q2q_control.failsafe.evasion.climb_back), or climbs there by more than BACK above.

| symbol | name | meaning [unit] |
|---|---|---|
| u | direction | horizontal unit vector, (2,) |
| d, a | reach, age | distance to keep [m], time since j was measured [s] |
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from q2q_control.failsafe.evasion.climb_back import BACK, ClimbBack, InFallback
from q2q_control.failsafe.evasion.evasion_direction import across, evasion_direction
from q2q_control.failsafe.evasion.evasion_shift import EvadedVehicle, EvasionShift
from q2q_control.failsafe.tracking_loss.dead_reckoned_braking import Reckoned
from q2q_model.signals.values import TRACKED, Array, Names, SwarmSetpoint, SwarmState, index_of, rows_by_name

REACH = 0.6
"""Horizontal distance to keep [m]: two vehicles in contact, 0.14, and the drift in 1 s of dead reckoning."""
RISE = 0.7
"""Height above one that is lost from which it is not evaded [m]: contact, 0.14, and its rise by 0.5."""
DRIFT_FROM_S, DRIFT = 1.0, 0.4
"""Time [s] after which a lost vehicle drifts unnoticed, and how fast [m/s]: what it has gained by then."""
FARTHEST = 0.9
"""Longest distance to keep [m]: REACH, and a drift of 0.75 s beyond DRIFT_FROM_S. A vehicle that evades
further leaves the room, or is not back within seconds; one that is driven further ahead gets across."""
LONGEST_STEP = 0.1
"""Longest time between ticks that is integrated [s]."""
CROSSING = 0.8
"""Height that another climbs while a vehicle gets across its path [m]: 0.8 m/s for the second of PACE."""


class DescentEvasion:
    """Shifts of all evading vehicles, and those that climb back."""

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Drop all shifts and climbs."""
        self._shifts: dict[str, EvasionShift] = {}
        self._climbs = ClimbBack()
        self.active = False
        """Whether any setpoint is shifted, or any vehicle climbs back."""
        self._t: float | None = None

    def update(
        self, setpoint: SwarmSetpoint, state: SwarmState, fallback: InFallback, known: Mapping[str, Reckoned]
    ) -> SwarmSetpoint:
        """Return the setpoints to fly.

        Args:
            setpoint: reference of the tick.
            state: of a lost vehicle, the last accepted height is used.
            fallback: vehicles without measurements, and cut ones.
            known: horizontal motions of vehicles, dead-reckoned; else the last accepted position of a lost
                vehicle is used, at rest.
        """
        dt = 0.0 if self._t is None else min(max(setpoint.t - self._t, 0.0), LONGEST_STEP)
        self._t = setpoint.t
        lost = fallback.lost
        if not lost and not self.active:
            return setpoint
        setpoint, returning = self._climbs.update(setpoint, state, fallback)
        pos, rest = _places(state, {name: known[name] for name in lost if name in known})
        self._end(returning.union(lost).intersection(state.names))
        self._begin_anew(setpoint, state.names, (pos[:, :2], rest), dt)
        sent, gone = _sent(setpoint, state.names, pos), index_of(state.names, lost) >= 0
        self._turn(returning, state, sent)
        reach, growth = _distances(state.age, gone)
        evading = ~gone & (index_of(state.names, setpoint.names) >= 0)
        for places in (pos, np.where(gone[:, None], pos, sent)):
            self._ask(_near_gone(places, evading, gone, reach), state.names, pos, rest)
        evaded = map(EvadedVehicle, map(tuple, pos[:, :2].tolist()), reach.tolist(), growth.tolist())
        unmeasured = frozenset(state.names[row] for row in np.flatnonzero(state.status != TRACKED))
        moved = self._moved(setpoint, dict(zip(state.names, evaded, strict=True)), unmeasured, dt)
        self._shifts = {name: shift for name, shift in self._shifts.items() if not shift.over}
        self.active = bool(self._shifts) or self._climbs.active
        return moved

    def _end(self, evaded: frozenset[str]) -> None:
        """End the evasions of all but some vehicles."""
        for shift in self._shifts.values():
            shift.directions = {name: u for name, u in shift.directions.items() if name in evaded}

    def _begin_anew(
        self, setpoint: SwarmSetpoint, names: Names, places: tuple[Array, Array], dt: float
    ) -> None:
        """Begin the evasions again, in new directions, of vehicles to which their setpoints jump.

        Args:
            setpoint: reference of the tick.
            names: of all vehicles.
            places: their positions and where they come to rest [m], (n, 2) each.
            dt: time since the last tick [s].
        """
        (xy, rest), evading = places, tuple(self._shifts)
        rows = zip(evading, index_of(evading, setpoint.names), index_of(evading, names), strict=True)
        for name, row, i in rows:
            if min(row, i) < 0:
                continue
            shift, step = self._shifts[name], dt * setpoint.vel[row, :2]
            if not shift.begin_at(setpoint.pos[row, :2], step, xy[i]):
                continue
            for other in shift.directions:
                j = names.index(other)
                shift.directions[other] = evasion_direction(xy, (i, j), rest[j], REACH)

    def _turn(self, back: frozenset[str], state: SwarmState, sent: Array) -> None:
        """Evade vehicles that are measured again where they are.

        - One that climbs, and is more than BACK above, is evaded no more.
        - A vehicle that one of them drives further than FARTHEST ahead gets across its path, if that is less
          far,
        - unless that one is below by less than CROSSING: it might climb into the vehicle on its way across.
        """
        xy = state.pos[:, :2]
        for name, shift in self._shifts.items():
            for other in back & shift.directions.keys() if name in state.names else ():
                i, j = state.names.index(name), state.names.index(other)
                if state.pos[j, 2] - state.pos[i, 2] > BACK and state.vel[j, 2] >= 0.0:
                    del shift.directions[other]
                elif other not in shift.returning:
                    shift.directions[other] = evasion_direction(xy, (i, j), xy[j], REACH)
                elif not 0.0 < state.pos[i, 2] - state.pos[j, 2] < CROSSING:
                    ahead, aside = shift.directions[other], xy[i] - xy[j]
                    shift.directions[other] = _nearer_way(sent[i, :2] - xy[j], ahead, across(ahead, aside))
            shift.returning = set(back & shift.directions.keys())

    def _ask(self, pairs: list[tuple[int, int]], names: Names, pos: Array, rest: Array) -> None:
        """Assign a direction to every new pair of an evading vehicle and the one that it evades."""
        for i, j in pairs:
            if names[i] not in self._shifts:
                self._shifts[names[i]] = EvasionShift()
            shift = self._shifts[names[i]]
            if names[j] not in shift.directions:
                shift.directions[names[j]] = evasion_direction(pos[:, :2], (i, j), rest[j], REACH)

    def _moved(
        self,
        setpoint: SwarmSetpoint,
        evaded: Mapping[str, EvadedVehicle],
        unmeasured: frozenset[str],
        dt: float,
    ) -> SwarmSetpoint:
        """Return the setpoints shifted from those that are evaded."""
        pos, vel, acc = setpoint.pos.copy(), setpoint.vel.copy(), setpoint.acc.copy()
        for row, name in enumerate(setpoint.names):
            shift = self._shifts.get(name)
            if shift is None:
                continue
            if name in unmeasured:
                target, target_vel = shift.resting_place, np.zeros(2)
            else:
                at = evaded[name].place if name in evaded else tuple(setpoint.pos[row, :2].tolist())
                target, target_vel = shift.goal(setpoint.pos[row], setpoint.vel[row], at, evaded)
            acc[row, :2] += shift.follow(target, target_vel, dt)
            pos[row, :2] += shift.pos
            vel[row, :2] += shift.vel
        return replace(setpoint, pos=pos, vel=vel, acc=acc)


def _nearer_way(sent: Array, ahead: Array, across_it: Array) -> Array:
    """Return the direction in which a vehicle evades: ahead, or across if that is nearer than FARTHEST ahead.

    Args:
        sent: where it is sent, from the other [m], (2,).
        ahead: direction in which the other drives it, (2,).
        across_it: direction across that, (2,).
    """
    further, aside = REACH - float(sent @ ahead), REACH - float(sent @ across_it)
    return across_it if further > max(FARTHEST, aside) else ahead


def _places(state: SwarmState, known: Mapping[str, Reckoned]) -> tuple[Array, Array]:
    """Return the positions [m], (n, 3), dead-reckoned where known, and those of rest, (n, 2).

    One that is measured without an attitude may never have been dead-reckoned: it is where it is measured.
    """
    rows, reckoned = index_of(tuple(known), state.names), np.array([*known.values()]).reshape(-1, 2, 2)
    used = (rows >= 0) & ~((state.status[rows] == TRACKED) & np.isnan(reckoned).any(axis=(1, 2)))
    pos, rest = state.pos.copy(), state.pos[:, :2].copy()
    pos[rows[used], :2], rest[rows[used]] = reckoned[used, 0], reckoned[used, 1]
    return pos, rest


def _sent(setpoint: SwarmSetpoint, names: Names, pos: Array) -> Array:
    """Return where vehicles are sent, and the positions of those that are not [m], (n, 3)."""
    return rows_by_name(setpoint.pos, setpoint.names, names, pos)


def _distances(age: Array, gone: NDArray[np.bool_]) -> tuple[Array, Array]:
    """Return the distance to keep from each vehicle [m] and how fast it grows [m/s], (n,) each.

    Args:
        age: of the measurement of each [s], (n,).
        gone: which of them are not measured, (n,).
    """
    grown = REACH + DRIFT * np.maximum(age - DRIFT_FROM_S, 0.0)
    grows = gone & (age > DRIFT_FROM_S) & (grown < FARTHEST)
    return np.where(gone, np.minimum(grown, FARTHEST), REACH), np.where(grows, DRIFT, 0.0)


def _near_gone(
    pos: Array, evading: NDArray[np.bool_], gone: NDArray[np.bool_], reach: Array
) -> list[tuple[int, int]]:
    """Return the rows of those `evading`, (n,), and of one `gone`, (n,), within its `reach` [m], (n,)."""
    near, far = np.flatnonzero(evading), np.flatnonzero(gone)
    offset = pos[near, None] - pos[far]
    close = np.hypot(offset[..., 0], offset[..., 1]) < reach[far]
    rows = np.nonzero(close & (offset[..., 2] < RISE))
    return list(zip(near[rows[0]].tolist(), far[rows[1]].tolist(), strict=True))
