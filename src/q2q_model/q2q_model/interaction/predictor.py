"""Predict every vehicle's draft, tick by tick, from an interaction model and the swarm's states.

    eta_i(t) = sum over j in reach of law(r_j(t - tau_ij) - r_i(t), v_j(t - tau_ij), b_j(t - tau_ij))

Pushes of several sources add up; so do the variances of their predictions. The air keeps the place where it
left its source, so a law with delay needs the sources' past: their states are remembered as long as the law's
longest delay. A source first seen within that time counts as if it had come from where it was first seen.

| input | answer |
|---|---|
| a stamp that was already answered | the same answer; no memory changes |
| a stamp older than the memory (a bag starts again) | the memory is forgotten |
| vehicles come, go, or change rows | memory follows the names |
| a source COASTING or LOST, or without a past | its push counts; STALE_SOURCE on the vehicle it pushes |
| NaN in a vehicle's position or velocity | neither feels nor causes; NO_MODEL, eta 0, std NaN |
| a source without orientation (NaN, one marker only) | counts as level |
| a model without reach (`none`) | NO_MODEL, eta 0, std NaN |
"""

import numpy as np
from numpy.typing import NDArray

from q2q_model.interaction.history import StateHistory
from q2q_model.interaction.model import InteractionModel, Reach, Source
from q2q_model.neighbours import pairs_in_reach
from q2q_model.rotations import rotate
from q2q_model.signals import (
    Array,
    Interference,
    InterferenceStatus,
    Names,
    SwarmState,
    TrackStatus,
    index_of,
)

Rows = NDArray[np.intp]


class InteractionPredictor:
    """Turn SwarmState into Interference; the model can be exchanged while flying."""

    def __init__(self, model: InteractionModel) -> None:
        self.model = model
        self.reset()

    def reset(self) -> None:
        """Forget where the vehicles were."""
        self._names: Names = ()
        self._history = StateHistory(0, 0.0)
        self._last: Interference | None = None

    def exchange(self, model: InteractionModel) -> None:
        """Use another model from the next stamp on; the past is kept as far as it is remembered."""
        if model.max_delay > self.model.max_delay:
            self.reset()
        self.model = model

    def update(self, state: SwarmState) -> Interference:
        """Return the draft on every vehicle of `state`, in its order."""
        if self._last is not None and state.t == self._last.t and state.names == self._last.names:
            return self._last
        now = _sources(state)
        self._remember(state, now)
        self._last = self._predict(state, now)
        return self._last

    def _remember(self, state: SwarmState, now: Source) -> None:
        if state.t < self._history.oldest:
            self.reset()
        if state.names != self._names:
            fresh = StateHistory(len(state.names), self.model.max_delay)
            rows = index_of(state.names, self._names)
            self._history = self._history.reordered(rows) if self._names else fresh
            self._names = state.names
        if state.t > self._history.newest:
            self._history.push(state.t, state.pos, now)

    def _predict(self, state: SwarmState, now: Source) -> Interference:
        n = len(state.names)
        acc, variance = np.zeros((n, 3)), np.zeros((n, 3))
        status = np.full(n, InterferenceStatus.VALID, dtype=np.uint8)
        seen = _finite_rows(state.pos, state.vel)
        i, j = pairs_in_reach(np.where(seen[:, None], state.pos, np.nan), self._reach(state.vel[seen]))
        if i.size:
            rel_pos, source, stale = self._retarded(state, now, i, j)
            np.add.at(acc, i, self.model.acceleration(rel_pos, source))
            np.add.at(variance, i, self.model.deviation(rel_pos, source) ** 2)
            status[i[stale]] = InterferenceStatus.STALE_SOURCE
        unknown = ~seen if self.model.reach.horizontal > 0.0 else np.ones(n, dtype=np.bool_)
        status[unknown], variance[unknown] = InterferenceStatus.NO_MODEL, np.nan
        return Interference(t=state.t, names=state.names, acc=acc, std=np.sqrt(variance), status=status)

    def _reach(self, vel: Array) -> Reach:
        """Return the model's reach, widened by how far a source may have moved within the delay."""
        reach = self.model.reach
        if self.model.max_delay == 0.0 or vel.size == 0:
            return reach
        moved = self.model.max_delay * float(np.sqrt((vel * vel).sum(axis=1).max()))
        return Reach(reach.horizontal + moved, reach.vertical + moved)

    def _retarded(
        self, state: SwarmState, now: Source, i: Rows, j: Rows
    ) -> tuple[Array, Source, NDArray[np.bool_]]:
        """Return rel_pos (p, 3) and source when the air left, and whether they are guesswork (p,)."""
        stale = np.not_equal(state.status[j], TrackStatus.TRACKED)
        rel_pos, source = state.pos[j] - state.pos[i], Source(now.vel[j], now.axis[j])
        if self.model.max_delay == 0.0:
            return rel_pos, source, stale
        past_pos, past = self._history.at(state.t - self.model.delay(rel_pos), j)
        lost = ~_finite_rows(past_pos, past.vel)
        if lost.any():
            past_pos = np.where(lost[:, None], state.pos[j], past_pos)
            vel = np.where(lost[:, None], source.vel, past.vel)
            past = Source(vel, np.where(lost[:, None], source.axis, past.axis))
        return past_pos - state.pos[i], past, stale | lost


UP = np.array([0.0, 0.0, 1.0])
"""Body z of a level vehicle."""


def _sources(state: SwarmState) -> Source:
    axis = rotate(state.quat, UP)
    return Source(vel=state.vel, axis=np.where(np.isfinite(axis), axis, UP))


def _finite_rows(pos: Array, vel: Array) -> NDArray[np.bool_]:
    return np.asarray(np.isfinite(np.concatenate((pos, vel), axis=1)).all(axis=1))
