"""Insertion sort of vehicles by x, from the order of the last step, which hardly changes."""

from q2q_model.compiled import HOT, compiled
from q2q_model.signals.values import Array, Rows


@compiled(**HOT)
def sort_by_x(x: Array, rows: Rows) -> bool:
    """Sort the first n entries of rows (n + 1,) by their x (n,) [m]; return whether the order has changed."""
    changed = False
    for a in range(1, x.shape[0]):
        row = rows[a]
        b = a - 1
        while b >= 0 and x[rows[b]] > x[row]:
            rows[b + 1] = rows[b]
            b -= 1
            changed = True
        rows[b + 1] = row
    return changed
