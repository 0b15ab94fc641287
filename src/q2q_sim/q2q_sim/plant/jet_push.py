"""Table of the push of a jet over gap and distance from its axis, bilinear between its nodes, compiled."""

from typing import NamedTuple

from q2q_model.compiled import BORROWING, compiled
from q2q_model.signals.values import Array


class PushTable(NamedTuple):
    """Table of P."""

    gaps: Array
    """[m], (a,)."""
    radii: Array
    """[m], (b,)."""
    push: Array
    """[m/s^2], (a, b)."""
    ends: Array
    """Radius within which a vehicle is in the jet [m], (a - 1,)."""


@compiled(**BORROWING)
def cell(knots: Array, value: float) -> int:
    """Return the last cell whose lower end is below `value`, from where evenly spaced knots would have it."""
    last = knots.shape[0] - 2
    k: int = min(int(value / knots[last + 1] * last), last)
    while k > 0 and value <= knots[k]:
        k -= 1
    while k < last and value > knots[k + 1]:
        k += 1
    return k


@compiled(**BORROWING)
def table_push(table: PushTable, a: int, gap: float, radius: float) -> float:
    """Return P [m/s^2] at a gap in the table's cell a."""
    gaps, radii, push = table.gaps, table.radii, table.push
    b = cell(radii, radius)
    along = min(max((gap - gaps[a]) / (gaps[a + 1] - gaps[a]), 0.0), 1.0)
    aside = max((radius - radii[b]) / (radii[b + 1] - radii[b]), 0.0)
    near = (1.0 - aside) * push[a, b] + aside * push[a, b + 1]
    far = (1.0 - aside) * push[a + 1, b] + aside * push[a + 1, b + 1]
    return float((1.0 - along) * near + along * far)
