"""Strength of each source's downwash at a vehicle, relative to the law of one pair.

The law of a pair holds for a source that carries its weight, with nothing in between. In a stack, a source
carries its weight and the downwash on it, and a vehicle in between takes momentum from the jet above it:

    eta_i = sum over j of s_ij f_ij
    s_ij  = 1 + l (T_j / (m g) - 1) - sum over k of min(1, c d_kj / g) min(1, d_ik / d_ij),   at least 0
    T_j   = m |a_j + g e_z| + m sum over k of d_jk

The last factor is 1 for k above i in the jet of j and 0 for k beside it. On real flights of three Crazyflies
l is about 0.6 and c about 1.5, and both wakes together have about 0.84 of the sum of the single ones
(docs/real_flights.md). A law without l and c adds its pairs up.

| symbol | name | meaning [unit] |
|---|---|---|
| f | law | downwash of j alone on i, z [m/s^2] |
| d | down | its downward part [m/s^2] |
| l | loading | growth of a source's downwash over that of its thrust, relative to hover [-] |
| c | absorption | share of a jet that a vehicle in it takes away, over its acceleration by it in g [-] |
| a_j | | acceleration of j when its air left it [m/s^2] |
"""

from typing import NamedTuple

import numpy as np

from q2q_model.compiled import compiled
from q2q_model.downwash.interaction_model import InteractionModel
from q2q_model.downwash.jet import Jet
from q2q_model.signals.values import Array, Rows
from q2q_model.vehicle.constants import GRAVITY

HALF_SPAN_S = 0.05
"""Half of the time over which a source's acceleration is measured [s]: below the jet's delay at 0.2 m."""


class SourceTerms(NamedTuple):
    """Terms of a model beyond its pairs."""

    loading: float = 0.0
    absorption: float = 0.0


PAIRS_ALONE = SourceTerms()


def source_terms(model: InteractionModel) -> SourceTerms:
    """Return a model's terms; PAIRS_ALONE for a model whose pairs add up."""
    return SourceTerms(model.loading, model.absorption) if isinstance(model, Jet) else PAIRS_ALONE


def thrust_ratio(before: Array, after: Array, span: Array) -> Array:
    """Return thrust over weight, (...,), of sources with velocities (..., 3) `span` (...,) apart [s]."""
    acc = (after - before) / np.maximum(span, 1e-6)[..., None]
    acc[..., 2] += GRAVITY
    return np.asarray(np.sqrt((acc * acc).sum(axis=-1)) / GRAVITY)


def strengths(i: Rows, j: Rows, law: Array, thrust_ratio: Array, terms: SourceTerms) -> Array:
    """Return s of pairs at N instants, (p, N).

    Args:
        i: Vehicle that feels, (p,), ascending.
        j: Vehicle that causes, (p,).
        law: Vertical downwash of each pair alone [m/s^2], (p, N).
        thrust_ratio: Thrust of j over its weight when its air left it, without the downwash on j, (p, N).
        terms: Loading and absorption.
    """
    feels, causes = np.ascontiguousarray(i), np.ascontiguousarray(j)
    first = np.searchsorted(feels, np.arange(max(feels.max(initial=0), causes.max(initial=0)) + 2))
    rows = (feels, causes, first)
    return _strengths(rows, np.ascontiguousarray(law), np.ascontiguousarray(thrust_ratio), terms)


@compiled
def _strengths(rows: tuple[Rows, Rows, Rows], law: Array, thrust_ratio: Array, terms: SourceTerms) -> Array:
    """Return s, (p, N); pairs of vehicle v are rows first[v] to first[v + 1]."""
    i, j, first = rows
    share = np.empty(law.shape)
    for p in range(law.shape[0]):
        for k in range(law.shape[1]):
            excess = thrust_ratio[p, k] - 1.0
            for q in range(first[j[p]], first[j[p] + 1]):
                excess += max(-law[q, k], 0.0) / GRAVITY
            share[p, k] = 1.0 + terms.loading * excess
        if terms.absorption > 0.0:
            for q in range(first[i[p]], first[i[p] + 1]):
                taken = _pair(j, first, j[q], j[p])
                if taken >= 0:
                    for k in range(law.shape[1]):
                        share[p, k] -= _absorbed(law[p, k], law[q, k], law[taken, k], terms.absorption)
        for k in range(law.shape[1]):
            share[p, k] = max(share[p, k], 0.0)
    return share


@compiled
def _pair(j: Rows, first: Rows, feels: int, causes: int) -> int:
    """Return the row of a pair, -1 if it is not in reach."""
    for q in range(first[feels], first[feels + 1]):
        if j[q] == causes:
            return q
    return -1


@compiled
def _absorbed(direct: float, middle: float, taken: float, absorption: float) -> float:
    """Return the share of f_ij that k takes: (f_ij, f_ik, f_kj, c)."""
    if direct >= 0.0 or middle >= 0.0 or taken >= 0.0:
        return 0.0
    return float(min(-absorption * taken / GRAVITY, 1.0) * min(middle / direct, 1.0))
