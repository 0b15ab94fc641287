"""Predicted height errors along a plan: altitude loop (13) under learned downwash (14).

    e_i'' = -K_d e_i' - K_p e_i + sum_j s_ij eta(r_j - r_i),    z_i = z_i,ref + e_i

Horizontally, vehicles follow their references; heights are the disturbed ones, so the downwash of a vehicle
includes the effect of the downwash on it. Semi-implicit Euler at the sampling of the references. Plans are
judged as in section 4 of the paper (Figs 11 and 13); delays and the motion of sources are neglected.
"""

import numpy as np

from q2q_model.downwash.interaction_model import InteractionModel, downwash_at_rest
from q2q_model.downwash.source_strength import PAIRS_ALONE, source_terms, strengths
from q2q_model.signals.values import Array
from q2q_model.vehicle.altitude_loop import AltitudeLoop


def altitude_errors(pos: Array, step: float, model: InteractionModel, loop: AltitudeLoop) -> Array:
    """Return the height errors e [m], (T, n).

    Args:
        pos: references [m], (T, n, 3).
        step: time between them [s].
        model: the downwash.
        loop: K_p and K_d.
    """
    ticks, n, _ = pos.shape
    i, j = np.nonzero(~np.eye(n, dtype=np.bool_))
    error, rate, terms = np.zeros(n), np.zeros(n), source_terms(model)
    errors = np.zeros((ticks, n))
    for tick in range(ticks):
        there = pos[tick] + np.stack([np.zeros(n), np.zeros(n), error], -1)
        rel_pos = there[j] - there[i]
        law = downwash_at_rest(model, rel_pos)[:, 2]
        if terms != PAIRS_ALONE:
            law = law * strengths(i, j, law[:, None], np.ones((i.size, 1)), terms)[:, 0]
        eta = np.bincount(i, law, minlength=n)
        rate += step * (eta - loop.k_d * rate - loop.k_p * error)
        error = error + step * rate
        errors[tick] = error
    return errors


def altitude_rms(pos: Array, step: float, model: InteractionModel, loop: AltitudeLoop) -> Array:
    """Return the root mean square of each vehicle's height error [m], (n,)."""
    return np.asarray(np.sqrt((altitude_errors(pos, step, model, loop) ** 2).mean(axis=0)))
