"""Explanation in one sentence."""

from q2q_sim.experiments.explanation.explanation import CauseShare, Explanation
from q2q_sim.experiments.explanation.loss import LOST
from q2q_sim.report.significant_digits import centimetres

PLACES = {"distance": "off", "height": "below"}
"""Where a vehicle is that lost distance or height."""
KEPT = {"distance": "No vehicle left its path", "height": "No vehicle lost height"}
"""What an ordinary flight is said to be."""
NAMED = 0.05
"""Share of the loss, either way, from which a cause is named [-]; the first one always is."""


def explanation_sentence(found: Explanation) -> str:
    """Return what was lost, by which causes, and what is lost without the first."""
    parts = ", ".join(_parts(found)) if found.loss.size > 0.0 else ""
    split = f"{_outcome(found)}: {parts}" if parts else _outcome(found)
    if found.first is None:
        return f"{split}."
    return f"{split}; flown again with only {found.first} taken out: {centimetres(found.without_first)}."


def _outcome(found: Explanation) -> str:
    """Return what was lost, and whether any cause explains it."""
    loss = found.loss
    amount = f"{LOST:g} m or more" if loss.size >= LOST else centimetres(loss.size)
    place = f"{amount} {PLACES[loss.kind]} its setpoint at {loss.t:.1f} s"
    if loss.is_ordinary:
        return f"{KEPT[loss.kind]} (largest error: {loss.vehicle} {place})"
    lost = f"{loss.vehicle} is {place}"
    return lost if found.first else f"{lost}; none of the known causes explains it"


def _parts(found: Explanation) -> list[str]:
    """Return the parts of the loss: first cause, others and rest; without a first cause, rest first."""
    least = NAMED * found.loss.size
    named = [one for one in found.shares if one.cause == found.first or abs(one.share) >= least]
    causes = [_words(one, first=one.cause == found.first) for one in named]
    rest = [f"{centimetres(found.rest)} with none of the causes"] if found.rest >= least else []
    return [*causes, *rest] if found.first else [*rest, *causes]


def _words(one: CauseShare, *, first: bool) -> str:
    """Return a share and its interval; without this where both ends read as the share does.

    The first cause is uncertain if another draw may have a share of 0.
    """
    low, share, high = (centimetres(value) for value in (one.low, one.share, one.high))
    doubt = ", uncertain" if first and one.low <= 0.0 else ""
    interval = "" if low == share == high else f" ({low.removesuffix(' cm')} to {high}{doubt})"
    return f"{share}{interval} by {one.cause}"
