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


def eta_along(model: InteractionModel, motion: Motion) -> Array:
    """Return eta [m/s^2], world, (T, n, 3)."""
    ticks, n = motion.pos.shape[:2]
    everywhere = np.arange(ticks)
    return np.stack([eta_on_vehicle(model, motion, i, everywhere) for i in range(n)], axis=1)


def eta_on_vehicle(model: InteractionModel, motion: Motion, i: int, rows: NDArray[np.intp]) -> Array:
    """Return eta of vehicle i at ticks `rows` (k,), [m/s^2], (k, 3)."""
    terms, others = source_terms(model), [j for j in range(motion.pos.shape[1]) if j != i]
    if terms == PAIRS_ALONE:
        eta = np.zeros((rows.size, 3))
        for j in others:
            _add_pair(model, motion, (i, j), rows, eta)
        return eta
    return _eta_of_stack(model, motion, i, rows)


def _eta_of_stack(model: InteractionModel, motion: Motion, i: int, rows: NDArray[np.intp]) -> Array:
    """Return eta of vehicle i at ticks `rows` (k,) with the strengths of its sources, (k, 3)."""
    terms = source_terms(model)
    feels, causes = np.nonzero(~np.eye(motion.pos.shape[1], dtype=np.bool_))
    law = np.zeros((feels.size, rows.size, 3))
    thrust = np.ones((feels.size, rows.size))
    for p, pair in enumerate(zip(feels.tolist(), causes.tolist(), strict=True)):
        _add_pair(model, motion, pair, rows, law[p])
        if terms.loading != 0.0:
            thrust[p] = _thrust_ratio(model, motion, pair, rows)
    share = strengths(feels, causes, np.ascontiguousarray(law[..., 2]), thrust, terms)
    own = feels == i
    return np.asarray((share[own, :, None] * law[own]).sum(axis=0))


def _add_pair(
    model: InteractionModel, motion: Motion, pair: tuple[int, int], rows: NDArray[np.intp], eta: Array
) -> None:
    """Add the downwash of source pair[1] alone on pair[0] to `eta` (k, 3)."""
    i, j = pair
    near = _in_reach(model, motion.pos[rows, j] - motion.pos[rows, i], motion.vel[:, j])
    ticks = rows[near]
    now = SourceStates(motion.pos[ticks, j], motion.vel[ticks, j], motion.axis[ticks, j])
    pairs = retarded_pairs(
        model,
        motion.pos[ticks, i],
        motion.vel[ticks, i],
        now,
        lambda delay: _at(motion, j, motion.t[ticks] - delay),
    )
    eta[near] += model.acceleration(*pairs)


def _thrust_ratio(
    model: InteractionModel, motion: Motion, pair: tuple[int, int], rows: NDArray[np.intp]
) -> Array:
    """Return thrust over weight of source pair[1] when the air that pair[0] meets at `rows` left it, (k,)."""
    i, j = pair
    now = motion.t[rows]
    left = now - model.delay(motion.pos[rows, j] - motion.pos[rows, i])
    before, after = left - HALF_SPAN_S, np.minimum(left + HALF_SPAN_S, now)
    return thrust_ratio(_at(motion, j, before).vel, _at(motion, j, after).vel, after - before)


def _in_reach(model: InteractionModel, rel_pos: Array, vel: Array) -> NDArray[np.bool_]:
    """Return where a source may act, (k,): within reach, allowing for its motion during the delay."""
    moved = 0.0
    if model.max_delay > 0.0:  # a cheap bound of the speed
        moved = model.max_delay * float(np.sqrt(3.0) * np.abs(vel).max(initial=0.0))
    across2 = rel_pos[:, 0] ** 2 + rel_pos[:, 1] ** 2
    wide, tall = model.reach.horizontal + moved, model.reach.vertical + moved
    return np.asarray((across2 <= wide * wide) & (np.abs(rel_pos[:, 2]) <= tall))


def _at(motion: Motion, j: int, when: Array) -> SourceStates:
    """Return vehicle j, interpolated at times (k,) [s]."""
    t, row = np.ascontiguousarray(motion.t), np.full(when.size, j)
    values = (np.ascontiguousarray(one) for one in (motion.pos, motion.vel, motion.axis))
    return SourceStates(*(states_at(t, one, when, row) for one in values))
