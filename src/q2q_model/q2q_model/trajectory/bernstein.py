"""Bounds of polynomials by their Bernstein coefficients: the control points' convex hull contains the curve.

p(t) = sum_k b_k C(m, k) u^k (1 - u)^(m - k), u = t / T in [0, 1]; the weights are positive and sum to one, so
p(t) lies in the convex hull of the b_k for every t of the interval (Farouki, The Bernstein polynomial
basis: a centennial retrospective, 2012). Halving the interval brings the hull four times closer to the curve.
"""

from functools import cache
from math import comb

import numpy as np

from q2q_model.signals.values import Array


def control_points(coefficients: Array, durations: Array) -> Array:
    """Return Bernstein coefficients (..., order) of ascending powers of t (..., order) on [0, T].

    `durations` T broadcasts against the leading axes of `coefficients`.
    """
    order = coefficients.shape[-1]
    unit = coefficients * np.asarray(durations)[..., None] ** np.arange(order)
    return np.asarray(unit @ _power_to_bernstein(order).T)


def ascending_powers(points: Array, durations: Array) -> Array:
    """Return the ascending powers of t (..., order) of Bernstein coefficients (..., order) on [0, T]."""
    order = points.shape[-1]
    unit = points @ _bernstein_to_power(order).T
    return np.asarray(unit / np.asarray(durations)[..., None] ** np.arange(order))


def split_in_half(points: Array) -> tuple[Array, Array]:
    """Return the control points of the first and the second half of the interval, (..., order) each."""
    first = _first_half(points.shape[-1])
    return np.asarray(points @ first.T), np.asarray(points @ first[::-1, ::-1].T)


@cache
def _power_to_bernstein(order: int) -> Array:
    """Return the matrix b_k = sum_{i <= k} C(k, i) / C(m, i) a_i."""
    degree = order - 1
    return np.array([[comb(k, i) / comb(degree, i) for i in range(order)] for k in range(order)])


@cache
def _bernstein_to_power(order: int) -> Array:
    """Return the matrix a_i = sum_{k <= i} (-1)^(i - k) C(m, i) C(i, k) b_k."""
    rows = range(order)
    return np.array([[(-1) ** (i - k) * comb(order - 1, i) * comb(i, k) for k in rows] for i in rows], float)


@cache
def _first_half(order: int) -> Array:
    """Return de Casteljau's matrix at u = 1/2: b_k of the first half = sum_i C(k, i) / 2^k b_i."""
    return np.array([[comb(k, i) / 2.0**k for i in range(order)] for k in range(order)])
