"""Online prediction of every vehicle's downwash from an interaction model and the swarm's states.

    eta_i(t) = sum over j in reach of s_ij law(r_j(t - tau) - r_i(t), v_j(t - tau), b_j(t - tau), v_i(t))

tau is that of the pair. s is 1, or the strength of q2q_model.downwash.source_strength if the model has its
terms. The accelerations of several sources add up, and so do the variances of their predictions. A law with
delay needs past states of the sources: a history as long as the law's largest delay holds them. A source
observed for less than its delay counts with its first observed state.

| input | output |
|---|---|
| a repeated stamp | the previous output; the history is unchanged |
| a late stamp, or one more than AHEAD_S ahead | not in the history |
| such stamps that go on (a bag restarts, a pause): signals.clock_resets | the history begins again |
| vehicles appear, vanish, or change rows | the history follows the names |
| a source COASTING or LOST, or without past states | included; STALE_SOURCE on the exposed vehicle |
| NaN in a vehicle's position or velocity; infinite age (never seen) | no pair; NO_MODEL, eta 0, std NaN |
| a source without orientation (NaN, one marker only) | level |
| a model without reach (`none`) | NO_MODEL, eta 0, std NaN |
"""

import numpy as np

from q2q_model.downwash.interaction_model import (
    InteractionModel,
    ModelOutputError,
    SourceStates,
    retarded_pairs,
)
from q2q_model.downwash.jet import Jet, jet_law
from q2q_model.downwash.predictor_kernel import (
    InteractionSums,
    PairInteractions,
    PlainJet,
    find_pairs,
    sum_over_sources,
    write_present,
    write_retarded,
)
from q2q_model.downwash.source_strength import (
    HALF_SPAN_S,
    PAIRS_ALONE,
    source_terms,
    strengths,
    thrust_ratio,
)
from q2q_model.downwash.state_history import StateHistory, state_rows
from q2q_model.downwash.sweep_and_prune import OrderedPairs
from q2q_model.geometry.pair_reach import beyond_rows
from q2q_model.signals.repeated_stamp import StampOrder, is_repeated
from q2q_model.signals.values import TRACKED, Array, Interference, Mask, Names, SwarmState, index_of

_NONE: Mask = np.zeros(0, dtype=np.bool_)
_NO_PAIR = PairInteractions(np.zeros((0, 3)), np.zeros((0, 3)), _NONE, _NONE)


class InteractionPredictor:
    """Block that maps SwarmState to Interference; the model can be exchanged in flight."""

    def __init__(self, model: InteractionModel) -> None:
        """Use a model; raise TypeError if it is none."""
        self._use(model)
        self.reset()

    def _use(self, model: InteractionModel) -> None:
        """Take a model, with what does not change from tick to tick."""
        if not isinstance(model, InteractionModel):
            kind = type(model).__name__
            raise TypeError(
                f"a {kind} is given; must be an InteractionModel, as `interaction` of a ModelFile"
            )
        self.model, self._terms, reach = model, source_terms(model), model.reach
        self._reach, self._late = (reach.horizontal, reach.vertical), model.max_delay > 0.0
        self._jet = _plain_jet(model)

    def reset(self) -> None:
        """Clear the history."""
        self._names: Names = ()
        self._history = StateHistory(0, 0.0)
        self._order = StampOrder()
        self._last: Interference | None = None

    def exchange(self, model: InteractionModel) -> None:
        """Use another model from the next stamp on; a history shorter than its delay is cleared."""
        if _span(model) > _span(self.model):
            self.reset()
        self._use(model)

    def update(self, state: SwarmState) -> Interference:
        """Return the downwash on every vehicle of `state`, in its order.

        Raises:
            ValueError: arrays do not have a row for each name.
            ModelOutputError: the model returns what cannot be flown with.
        """
        if is_repeated(self._last, state.t, state.names):
            return self._last
        states = state_rows(state)
        acc, std = np.empty(state.pos.shape), np.empty(state.pos.shape)
        status = np.empty(len(state.names), dtype=np.uint8)
        if self._jet is None or self._late:
            self._sum(state, states, InteractionSums(acc, std, status))
        else:
            write_present(states, state.status.copy(), self._jet, (acc, std, status))
        self._last = Interference(state.t, state.names, acc, std, status)
        return self._last

    def _sum(self, state: SwarmState, states: Array, sums: InteractionSums) -> None:
        """Write the sums over all sources, whose past the model may need."""
        now = np.empty((len(state.names), 9))
        past, taken = self._past_of(state)
        pairs = find_pairs(states, now, past.held[1] if self._late else past.held[1][:0], self._reach)
        if taken:
            past.push(state.t, now)
        if self._jet is not None:
            tick = state.t, now, state.status.copy()
            write_retarded(pairs, tick, past.held, self._jet, (*sums,))
            return
        try:
            outputs = self._outputs(state, now, pairs, past) if pairs[0].size else _NO_PAIR
        except ModelOutputError as error:
            raise _with_names(error, state, pairs) from error
        sum_over_sources(pairs, outputs, now, self._reach[0] > 0.0, sums)

    def _past_of(self, state: SwarmState) -> tuple[StateHistory, bool]:
        """Return the history in the rows of a state, and whether the state is to be added to it."""
        rejected = self._order.reject_stamp(state.t)
        if self._order.was_set:
            self._names = ()  # the history begins again
        past = self._history
        if state.names != self._names:
            fresh = StateHistory(len(state.names), _span(self.model))
            past = past.reordered(index_of(state.names, self._names)) if self._names else fresh
        if rejected:
            return past, False
        self._history, self._names = past, state.names
        return past, state.t > past.newest

    def _outputs(
        self, state: SwarmState, now: Array, pairs: OrderedPairs, history: StateHistory
    ) -> PairInteractions:
        """Return the outputs of the model for the pairs of a tick."""
        i, j = pairs
        feels, causes = now[i], now[j]
        stale: Mask = np.not_equal(state.status[j], TRACKED)

        def past(delay: Array) -> SourceStates:
            found = history.at(state.t - delay, j)
            unknown = np.asarray(~np.isfinite(found[:, :6]).all(axis=1))
            if unknown.any():
                stale[unknown], found[unknown] = True, causes[unknown]
            return SourceStates.of_rows(found)

        there = retarded_pairs(self.model, feels[:, :3], feels[:, 3:6], SourceStates.of_rows(causes), past)
        ended = beyond_rows(there.rel_pos, there.now, self._reach)
        eta = self.model.acceleration(there.rel_pos, there.motion)
        deviation = self.model.deviation(there.rel_pos, there.motion)
        if self._terms != PAIRS_ALONE:
            thrust = self._thrust_ratio(state.t, now, pairs, history)
            share = strengths(i, j, np.where(ended[:, None], 0.0, eta[:, 2:]), thrust, self._terms)
            eta, deviation = share * eta, share * deviation
        return PairInteractions(eta, deviation, stale, ended)

    def _thrust_ratio(self, t: float, now: Array, pairs: OrderedPairs, history: StateHistory) -> Array:
        """Return thrust over weight of each pair's source when its air left it, (p, 1); 1 where unknown."""
        i, j = pairs
        if self._terms.loading == 0.0:
            return np.ones((j.size, 1))
        left = t - self.model.delay(now[j, :3] - now[i, :3])
        before, after = left - HALF_SPAN_S, np.minimum(left + HALF_SPAN_S, t)
        vel = [history.at(when, j)[:, 3:6] for when in (before, after)]
        seen = np.minimum(after, history.newest) - np.maximum(before, history.oldest)
        ratio = thrust_ratio(vel[0], vel[1], seen)
        return np.where(np.isfinite(ratio) & (seen > 0.5 * HALF_SPAN_S), ratio, 1.0)[:, None]


def _with_names(error: ModelOutputError, state: SwarmState, pairs: OrderedPairs) -> ModelOutputError:
    """Return the error with its time, and with the vehicles of its pair."""
    if error.pair is None:
        return ModelOutputError(f"at {state.t:.3f} s: {error}")
    feels, causes = (state.names[rows[error.pair]] for rows in pairs)
    return ModelOutputError(f"{feels} in the downwash of {causes} at {state.t:.3f} s: {error}", error.pair)


def _span(model: InteractionModel) -> float:
    """Return the length of the history that a model needs [s]."""
    return model.max_delay + (HALF_SPAN_S if source_terms(model).loading > 0.0 else 0.0)


def _plain_jet(model: InteractionModel) -> PlainJet | None:
    """Return law, deviation and reach of a jet without terms between sources; None for other models."""
    if not isinstance(model, Jet) or source_terms(model) != PAIRS_ALONE:
        return None
    reach, spread = model.reach, (float(model.relative_std), float(model.std_floor))
    return np.array(jet_law(model), dtype=np.float64), (*spread, reach.horizontal, reach.vertical)
