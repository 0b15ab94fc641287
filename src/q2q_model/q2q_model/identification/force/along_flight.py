"""An interaction model evaluated along a recorded flight, all ticks at once.

The sum is that of the online predictor (q2q_model.downwash.predictor), as a test checks:

    eta_i(t) = sum over j of s_ij law(r_j(t - tau) - r_i(t), v_j(t - tau), b_j(t - tau), v_i(t))

with the strengths s of q2q_model.downwash.source_strength. The past of a vehicle is the whole record,
extended before its start by the first sample.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from q2q_model.downwash.interaction_model import InteractionModel, PairMotion
from q2q_model.downwash.source_strength import (
    HALF_SPAN_S,
    PAIRS_ALONE,
    source_terms,
    strengths,
    thrust_ratio,
)
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
    rel_pos = motion.pos[rows, j] - motion.pos[rows, i]
    near = _in_reach(model, rel_pos, motion.vel[:, j])
    pos, vel, axis = _delayed_state(model, motion, j, rows[near], rel_pos[near])
    moving = PairMotion(source_vel=vel, source_axis=axis, vel=motion.vel[rows[near], i])
    eta[near] += model.acceleration(pos - motion.pos[rows[near], i], moving)


def _thrust_ratio(
    model: InteractionModel, motion: Motion, pair: tuple[int, int], rows: NDArray[np.intp]
) -> Array:
    """Return thrust over weight of source pair[1] when the air that pair[0] meets at `rows` left it, (k,)."""
    i, j = pair
    now = motion.t[rows]
    left = now - model.delay(motion.pos[rows, j] - motion.pos[rows, i])
    before, after = left - HALF_SPAN_S, np.minimum(left + HALF_SPAN_S, now)
    return thrust_ratio(_at(motion, j, before)[1], _at(motion, j, after)[1], after - before)


def _in_reach(model: InteractionModel, rel_pos: Array, vel: Array) -> NDArray[np.bool_]:
    """Return where a source may act, (k,): within reach, allowing for its motion during the delay."""
    moved = 0.0
    if model.max_delay > 0.0:  # a cheap bound of the speed
        moved = model.max_delay * float(np.sqrt(3.0) * np.abs(vel).max(initial=0.0))
    across2 = rel_pos[:, 0] ** 2 + rel_pos[:, 1] ** 2
    wide, tall = model.reach.horizontal + moved, model.reach.vertical + moved
    return np.asarray((across2 <= wide * wide) & (np.abs(rel_pos[:, 2]) <= tall))


def _delayed_state(
    model: InteractionModel, motion: Motion, j: int, rows: NDArray[np.intp], rel_pos: Array
) -> tuple[Array, Array, Array]:
    """Return pos, vel and axis of j, (k, 3), at the time that air arriving at ticks `rows` left it."""
    if model.max_delay == 0.0:
        return motion.pos[rows, j], motion.vel[rows, j], motion.axis[rows, j]
    return _at(motion, j, motion.t[rows] - model.delay(rel_pos))


def _at(motion: Motion, j: int, when: Array) -> tuple[Array, Array, Array]:
    """Return pos, vel and axis of j, (k, 3), interpolated at times (k,)."""
    after = np.searchsorted(motion.t, when).clip(1, motion.t.size - 1)
    before = after - 1
    share = (when - motion.t[before]) / (motion.t[after] - motion.t[before])
    share = share.clip(0.0, 1.0)[:, None]

    def between(values: Array) -> Array:
        return np.asarray((1.0 - share) * values[before, j] + share * values[after, j])

    return between(motion.pos), between(motion.vel), between(motion.axis)
