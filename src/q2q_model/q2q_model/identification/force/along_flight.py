"""An interaction model evaluated along a recorded flight, all ticks at once.

The sum is that of the online predictor (q2q_model.downwash.predictor), as a test checks:

    eta_i(t) = sum over j of s_ij law(r_j(t - tau) - r_i(t), v_j(t - tau), b_j(t - tau), v_i(t))

with the strengths s of q2q_model.downwash.source_strength. The past of a vehicle is the whole record,
extended before its start by the first sample.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from q2q_model.downwash.interaction_model import InteractionModel, SourceStates, retarded_pairs
from q2q_model.downwash.source_strength import (
    HALF_SPAN_S,
    PAIRS_ALONE,
    source_terms,
    strengths,
    thrust_ratio,
)
from q2q_model.downwash.state_history import states_at
from q2q_model.signals.values import Array

Pair = tuple[int, int]
"""Vehicle that feels, vehicle that causes."""


@dataclass(frozen=True, slots=True)
class Motion:
    """Motion of a swarm over time, without gaps."""

    t: Array
    """[s], rising, (T,)."""
    pos: Array
    """[m], world, (T, n, 3)."""
    vel: Array
    """[m/s], world, (T, n, 3)."""
    axis: Array
    """Body z, world, (T, n, 3)."""


@dataclass(frozen=True, slots=True)
class _PairRows:
    """States of a pair at the rows."""

    feels: Array
    """pos, vel, axis of the vehicle that feels, (k, 9)."""
    causes: Array
    """Of the source, (k, 9)."""
    across2: Array
    """Square of the horizontal distance [m^2], (k,)."""
    apart: Array
    """|dz| [m], (k,)."""
    fastest: float
    """Bound of the source's speed [m/s]."""


class VehicleRows:
    """One vehicle of a flight at some ticks, gathered once for the evaluation of many models."""

    def __init__(self, motion: Motion, vehicle: int, ticks: NDArray[np.intp]) -> None:
        """Gather vehicle number `vehicle` at `ticks` (k,)."""
        self.ticks = ticks
        self._vehicle = vehicle
        self._t, self._vel = np.ascontiguousarray(motion.t), np.ascontiguousarray(motion.vel)
        self._states = np.concatenate((motion.pos, motion.vel, motion.axis), axis=2)  # (T, n, 9)
        self._pairs: dict[Pair, _PairRows] = {}

    def eta(self, model: InteractionModel) -> Array:
        """Return eta of the vehicle [m/s^2], (k, 3)."""
        if source_terms(model) != PAIRS_ALONE:
            return self._eta_of_stack(model)
        eta = np.zeros((self.ticks.size, 3))
        for j in range(self._states.shape[1]):
            if j != self._vehicle:
                self._add_pair(model, (self._vehicle, j), eta)
        return eta

    def _eta_of_stack(self, model: InteractionModel) -> Array:
        """Return eta with the strengths of the sources, (k, 3)."""
        terms = source_terms(model)
        feels, causes = np.nonzero(~np.eye(self._states.shape[1], dtype=np.bool_))
        law = np.zeros((feels.size, self.ticks.size, 3))
        thrust = np.ones((feels.size, self.ticks.size))
        for p, pair in enumerate(zip(feels.tolist(), causes.tolist(), strict=True)):
            self._add_pair(model, pair, law[p])
            if terms.loading != 0.0:
                thrust[p] = self._thrust_ratio(model, pair)
        share = strengths(feels, causes, np.ascontiguousarray(law[..., 2]), thrust, terms)
        own = feels == self._vehicle
        return np.asarray((share[own, :, None] * law[own]).sum(axis=0))

    def _add_pair(self, model: InteractionModel, pair: Pair, eta: Array) -> None:
        """Add the downwash of source pair[1] alone on pair[0] to `eta` (k, 3)."""
        rows = self._rows(pair)
        near = np.flatnonzero(_in_reach(model, rows))
        now, feels, t = rows.causes[near], rows.feels[near], self._t[self.ticks[near]]
        pairs = retarded_pairs(
            model, feels[:, :3], feels[:, 3:6], _sources(now), lambda delay: self._source_at(pair, t - delay)
        )
        eta[near] += model.acceleration(*pairs)

    def _thrust_ratio(self, model: InteractionModel, pair: Pair) -> Array:
        """Return thrust over weight of source pair[1] when the air that pair[0] meets left it, (k,)."""
        rows, now = self._rows(pair), self._t[self.ticks]
        left = now - model.delay(rows.causes[:, :3] - rows.feels[:, :3])
        before, after = left - HALF_SPAN_S, np.minimum(left + HALF_SPAN_S, now)
        source = np.full(now.size, pair[1])
        vel = [states_at(self._t, self._vel, when, source) for when in (before, after)]
        return thrust_ratio(vel[0], vel[1], after - before)

    def _source_at(self, pair: Pair, when: Array) -> SourceStates:
        """Return source pair[1], interpolated at times (k,) [s]."""
        return _sources(states_at(self._t, self._states, when, np.full(when.size, pair[1])))

    def _rows(self, pair: Pair) -> _PairRows:
        """Return the states of a pair, gathered once."""
        if pair not in self._pairs:
            feels, causes = (self._states[self.ticks, vehicle] for vehicle in pair)
            rel_pos = causes[:, :3] - feels[:, :3]
            across2 = rel_pos[:, 0] ** 2 + rel_pos[:, 1] ** 2
            vel = self._states[:, pair[1], 3:6]
            fastest = float(np.sqrt(3.0) * np.abs(vel).max(initial=0.0))
            self._pairs[pair] = _PairRows(feels, causes, across2, np.abs(rel_pos[:, 2]), fastest)
        return self._pairs[pair]


def eta_along(model: InteractionModel, motion: Motion) -> Array:
    """Return eta [m/s^2], world, (T, n, 3)."""
    ticks, n = motion.pos.shape[:2]
    everywhere = np.arange(ticks)
    return np.stack([eta_on_vehicle(model, motion, i, everywhere) for i in range(n)], axis=1)


def eta_on_vehicle(model: InteractionModel, motion: Motion, i: int, rows: NDArray[np.intp]) -> Array:
    """Return eta of vehicle i at ticks `rows` (k,), [m/s^2], (k, 3)."""
    return VehicleRows(motion, i, rows).eta(model)


def _in_reach(model: InteractionModel, rows: _PairRows) -> NDArray[np.bool_]:
    """Return where a source may act, (k,): within reach, allowing for its motion during the delay."""
    moved = model.max_delay * rows.fastest if model.max_delay > 0.0 else 0.0
    wide, tall = model.reach.horizontal + moved, model.reach.vertical + moved
    return np.asarray((rows.across2 <= wide * wide) & (rows.apart <= tall))


def _sources(states: Array) -> SourceStates:
    return SourceStates(states[:, :3], states[:, 3:6], states[:, 6:])
