"""Braking of a plan in flight, by slowing its clock: vehicles stay on their certified paths until they rest.

Plan time s runs as s(tau) = s_0 + tau - tau^2 / (2 T), from rate 1 to rest within T. All vehicles share the
plan time, so they keep the relative positions for which the plan was certified. On each piece the polynomial
in s becomes one of twice its degree in tau.
"""

from dataclasses import replace

import numpy as np
from numpy.polynomial import polynomial

from q2q_model.signals.values import Array
from q2q_model.trajectory.polynomials import AXES, SwarmPlan, Trajectory

BRAKE_S = 1.0
"""T [s]: adds an acceleration of v / T to the plan's own, 1 m/s^2 at 1 m/s."""
SHORTEST_PIECE_S = 1e-6
"""Shortest piece of plan time that is kept [s]: 1 um at 1 m/s. A trajectory at rest takes as long."""


def brake_plan(plan: SwarmPlan, s: float) -> SwarmPlan:
    """Return the plan that starts at plan time s [s] of `plan` and comes to rest within BRAKE_S.

    Before its start and after its end it is at rest already.
    """
    curves = tuple(_braked(one, s) for one in plan.trajectories)
    return replace(plan, trajectories=curves)


def _braked(curve: Trajectory, s: float) -> Trajectory:
    ends = np.cumsum(curve.durations)
    begin, last = float(np.clip(s, 0.0, ends[-1])), min(s + 0.5 * BRAKE_S, float(ends[-1]))
    between = (ends > begin + SHORTEST_PIECE_S) & (ends < last - SHORTEST_PIECE_S)
    knots = np.array([begin, *ends[between], last])
    if s <= 0.0 or last - begin <= SHORTEST_PIECE_S:  # at rest before its start or after its end
        point = curve.at(np.array(begin))
        return Trajectory(np.array([SHORTEST_PIECE_S]), point.reshape(1, AXES, 1))
    tau = BRAKE_S - np.sqrt(np.maximum(BRAKE_S**2 - 2.0 * BRAKE_S * (knots - s), 0.0))
    order = 2 * curve.coefficients.shape[-1] - 1
    pieces = np.zeros((len(knots) - 1, AXES, order))
    for k in range(len(knots) - 1):
        after = knots[k] + 0.5 * SHORTEST_PIECE_S
        piece = min(int(np.searchsorted(ends, after, side="right")), len(ends) - 1)
        start = ends[piece] - curve.durations[piece]
        inner = np.array([knots[k] - start, 1.0 - tau[k] / BRAKE_S, -0.5 / BRAKE_S])
        for axis in range(AXES):
            composed = _composed(curve.coefficients[piece, axis], inner)
            pieces[k, axis, : len(composed)] = composed
    return Trajectory(np.diff(tau), pieces)


def _composed(outer: Array, inner: Array) -> Array:
    """Return the coefficients of outer(inner(tau)), by Horner's scheme."""
    value = outer[-1:]
    for coefficient in outer[-2::-1]:
        value = polynomial.polyadd(polynomial.polymul(value, inner), np.array([coefficient]))
    return np.asarray(value, dtype=np.float64)
