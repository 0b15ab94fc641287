"""Polynomial pieces from derivatives at their ends, and their exact energy.

A piece of degree 2k - 1 is fixed by its value and first k - 1 derivatives at both ends, and is the curve
of smallest energy int (d^k x / dt^k)^2 dt among all curves with those end data (the Euler-Lagrange
equation is d^2k x / dt^2k = 0). On the unit interval u = t / T, with end data scaled by powers of T:

    c = H_k S(T) v,    v = (x, x', ..., x^(k-1) at the start; the same at the end),    S = diag(T^p)
    int_0^T (x^(k))^2 dt = v' S Q_k S v / T^(2k-1),    Q_k = H_k' G_k H_k,
    G_k[i, j] = int_0^1 (u^i)^(k) (u^j)^(k) du

| symbol | name | meaning [unit] |
|---|---|---|
| k | half | half the piece's order; 4 for snap, 2 for yaw acceleration |
| H_k | hermite_matrix | end data to ascending coefficients of u, (2k, 2k) |
| G_k | power_gram | energy of coefficients, (2k, 2k) |
| Q_k | hermite_energy | energy of end data, (2k, 2k) |
| T | duration | length of the piece [s] |
"""

from functools import cache
from math import perm

import numpy as np

from q2q_model.signals.values import Array


@cache
def hermite_matrix(half: int) -> Array:
    """Return H_k: unit-interval end data (2k,) to ascending coefficients (2k,)."""
    order = 2 * half
    ends = np.zeros((order, order))  # coefficients to end data
    for p in range(half):
        ends[p, p] = perm(p, p)
        ends[half + p] = [perm(power, p) for power in range(order)]  # (u^power)^(p) at u = 1
    matrix = np.rint(np.linalg.solve(ends, np.eye(order)) * perm(half, half)) / perm(half, half)
    return _read_only(matrix)  # entries are rational with denominator (k-1)!


def power_gram(order: int, derivative: int) -> Array:
    """Return G: int_0^1 (u^i)^(k) (u^j)^(k) du for i, j below `order`, k the derivative."""
    gram = np.zeros((order, order))
    for i in range(derivative, order):
        for j in range(derivative, order):
            gram[i, j] = perm(i, derivative) * perm(j, derivative) / (i + j - 2 * derivative + 1)
    return gram


@cache
def hermite_energy(half: int) -> Array:
    """Return Q_k: int_0^1 (x^(k))^2 du as a quadratic form of unit-interval end data, (2k, 2k)."""
    matrix = hermite_matrix(half)
    return _read_only(matrix.T @ power_gram(2 * half, half) @ matrix)


def end_scales(durations: Array, half: int) -> Array:
    """Return diag S: T^p for p = 0..k-1, twice, (..., 2k), for durations (...,) [s]."""
    powers = durations[..., None] ** np.arange(half)
    return np.concatenate([powers, powers], axis=-1)


def pieces_from_nodes(nodes: Array, durations: Array) -> Array:
    """Return ascending coefficients of t, (pieces, axes, 2k), through nodal data.

    Args:
        nodes: value and first k - 1 derivatives at each knot [m/s^p], (knots, axes, k).
        durations: lengths of the pieces between the knots [s], (knots - 1,).
    """
    half = nodes.shape[-1]
    ends = np.concatenate([nodes[:-1], nodes[1:]], axis=-1)  # (pieces, axes, 2k)
    unit = (ends * end_scales(durations, half)[:, None, :]) @ hermite_matrix(half).T
    return np.asarray(unit / (durations[:, None] ** np.arange(2 * half))[:, None, :])


def piece_energies(durations: Array, half: int) -> Array:
    """Return the energy of each piece as a quadratic form of its end data, (pieces, 2k, 2k)."""
    scales = end_scales(durations, half)
    powers = durations ** (2 * half - 1)
    return np.asarray(scales[:, :, None] * hermite_energy(half) * scales[:, None, :] / powers[:, None, None])


def _read_only(matrix: Array) -> Array:
    matrix.setflags(write=False)
    return matrix
