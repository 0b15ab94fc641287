"""Shapley values over random orders (Shapley, 1953; Castro, Gomez and Tejada, 2009).

Causes are taken out one after the other, until none is left. In an order o

    share of c = v(causes before c in o) - v(causes before c in o, and c)

with v(S) the loss without the causes S. The Shapley value of c is the mean of its share over all orders: the
shares add up to v(none) - v(all), and causes that only act together share alike. Where all sets of causes are
as few as those of the wanted orders may be, all orders are taken: n causes have 2^n sets, and m random orders
up to m (n - 1) + 2.

Random orders are drawn in pairs, one the reverse of the other. Where the share of a cause in one is large if
it is small in the other, as of causes that only act together, that halves the variance or better. Where both
are alike, as if the loss is gone once a number of any causes is out, a pair is no more than one order.
"""

from collections.abc import Callable, Sequence
from itertools import permutations

import numpy as np
from scipy.special import stdtrit

from q2q_model.identification.statistics.intervals import LEVEL
from q2q_model.signals.values import Array

ValueOfCauses = Callable[[frozenset[str]], float]
"""v."""
CauseOrder = tuple[str, ...]
UPPER = 0.5 + 0.5 * LEVEL
"""Level of the upper end of a two-sided 95 % interval [-]."""


def all_orders_fit(causes: Sequence[str], most: int) -> bool:
    """Return whether all sets of causes are no more than those of `most` random orders may be."""
    return (1 << len(causes)) <= max(1, most * (len(causes) - 1) + 2)


def orders_of(causes: Sequence[str], most: int, rng: np.random.Generator) -> list[CauseOrder]:
    """Return all orders if `all_orders_fit`, else `most` random ones in pairs."""
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


def half_widths_of_orders(found: Array) -> Array:
    """Return half widths of 95 % intervals of the mean shares over random orders in pairs, (causes,).

    The larger of those from the orders, as if independent, and from the means of pairs: few pairs are often
    alike by chance, and the orders are not independent where the shares in a pair are alike. A share that is
    large in few orders is still underestimated, as these may not be among the drawn.

    Args:
        found: shares, (orders, causes); an even number of 4 or more orders, each followed by its reverse.
    """
    pairs = found.reshape(len(found) // 2, 2, -1).mean(axis=1)
    return np.maximum(_half_widths(found), _half_widths(pairs))


def _half_widths(draws: Array) -> Array:
    """Return the half widths of the intervals of the means of independent draws (n, causes), (causes,)."""
    error = draws.std(axis=0, ddof=1) / np.sqrt(len(draws))
    return np.asarray(stdtrit(len(draws) - 1, UPPER) * error)
