"""Shapley values over random orders (Shapley, 1953; Castro, Gomez and Tejada, 2009).

Causes are taken out one after the other, until none is left. In an order o

    share of c = v(causes before c in o) - v(causes before c in o, and c)

with v(S) the loss without the causes S. The Shapley value of c is the mean of its share over all orders: the
shares add up to v(none) - v(all), and causes that only act together share alike. Orders are drawn in pairs,
one the reverse of the other, which halves the variance or better.
"""

from collections.abc import Callable, Sequence
from itertools import permutations
from math import factorial

import numpy as np

from q2q_model.signals.values import Array

ValueOfCauses = Callable[[frozenset[str]], float]
"""v."""
CauseOrder = tuple[str, ...]


def all_orders_fit(causes: Sequence[str], most: int) -> bool:
    """Return whether there are at most `most` orders."""
    return factorial(len(causes)) <= most


def orders_of(causes: Sequence[str], most: int, rng: np.random.Generator) -> list[CauseOrder]:
    """Return all orders if there are at most `most`, else `most` random ones in pairs."""
    if all_orders_fit(causes, most):
        return list(permutations(causes))
    drawn = [tuple(str(cause) for cause in rng.permutation(causes)) for _ in range(most // 2)]
    return [one for order in drawn for one in (order, order[::-1])]


def shapley_shares(causes: Sequence[str], orders: Sequence[CauseOrder], value: ValueOfCauses) -> Array:
    """Return the share of each cause in each order, (orders, causes)."""
    found = np.empty((len(orders), len(causes)))
    for row, order in enumerate(orders):
        losses = [value(frozenset(order[:k])) for k in range(len(order) + 1)]
        for k, cause in enumerate(order):
            found[row, causes.index(cause)] = losses[k] - losses[k + 1]
    return found


def standard_error(found: Array) -> Array:
    """Return the standard error of the mean share of each cause over random orders, (causes,).

    It is that of independent orders. Reversed ones make the true error smaller, but the few pairs are often
    alike by chance, so that the deviation between them is no estimate of it.
    """
    return np.asarray(found.std(axis=0, ddof=1) / np.sqrt(len(found)))
