"""Predict every vehicle's draft, tick by tick, from an interaction model and the swarm's states.

    eta_i(t) = sum over j in reach of law(r_j(t - tau_ij) - r_i(t), v_j(t - tau_ij), b_j(t - tau_ij), v_i(t))

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
from q2q_model.interaction.model import UP, InteractionModel, PairMotion, Reach
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
        axis = _body_z(state)
        self._remember(state, axis)
        self._last = self._predict(state, axis)
        return self._last

    def _remember(self, state: SwarmState, axis: Array) -> None:
        if state.t < self._history.oldest:
            self.reset()
        if state.names != self._names:
            fresh = StateHistory(len(state.names), self.model.max_delay)
            rows = index_of(state.names, self._names)
            self._history = self._history.reordered(rows) if self._names else fresh
            self._names = state.names
        if state.t > self._history.newest:
            self._history.push(state.t, state.pos, state.vel, axis)

    def _predict(self, state: SwarmState, axis: Array) -> Interference:
        n = len(state.names)
        acc, variance = np.zeros((n, 3)), np.zeros((n, 3))
        status = np.full(n, InterferenceStatus.VALID, dtype=np.uint8)
        seen = _finite_rows(state.pos, state.vel)
        i, j = pairs_in_reach(np.where(seen[:, None], state.pos, np.nan), self._reach(state.vel[seen]))
        if i.size:
            rel_pos, motion, stale = self._retarded(state, axis, i, j)
            np.add.at(acc, i, self.model.acceleration(rel_pos, motion))
            np.add.at(variance, i, self.model.deviation(rel_pos, motion) ** 2)
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
        self, state: SwarmState, axis: Array, i: Rows, j: Rows
    ) -> tuple[Array, PairMotion, NDArray[np.bool_]]:
        """Return rel_pos (p, 3) and motion as the air left, and whether they are guesswork (p,)."""
        stale = np.not_equal(state.status[j], TrackStatus.TRACKED)
        rel_pos, now = state.pos[j] - state.pos[i], PairMotion(state.vel[j], axis[j], state.vel[i])
        if self.model.max_delay == 0.0:
            return rel_pos, now, stale
        pos, vel, leaning = self._history.at(state.t - self.model.delay(rel_pos), j)
        lost = ~_finite_rows(pos, vel)
        if lost.any():
            pos[lost], vel[lost], leaning[lost] = state.pos[j][lost], state.vel[j][lost], axis[j][lost]
        return pos - state.pos[i], PairMotion(vel, leaning, now.vel), stale | lost


def _body_z(state: SwarmState) -> Array:
    axis = rotate(state.quat, UP)
    return np.where(np.isfinite(axis), axis, UP)


def _finite_rows(pos: Array, vel: Array) -> NDArray[np.bool_]:
    return np.asarray(np.isfinite(np.concatenate((pos, vel), axis=1)).all(axis=1))
