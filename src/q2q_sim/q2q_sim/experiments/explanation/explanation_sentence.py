"""Explanation in one sentence."""

from q2q_sim.experiments.explanation.explanation import CauseShare, Explanation
from q2q_sim.experiments.explanation.loss import LOST
from q2q_sim.report.significant_digits import centimetres

PLACES = {"distance": "off", "height": "below"}
"""Where a vehicle is that lost distance or height."""
NAMED = 0.05
"""Share of the loss, either way, from which a cause is named [-]; the first one always is."""


def explanation_sentence(found: Explanation) -> str:
    """Return what was lost, by which causes, and what is lost without the first."""
    loss = found.loss
    amount = f"{LOST:g} m or more" if loss.size >= LOST else centimetres(loss.size)
    lost = f"{loss.vehicle} is {amount} {PLACES[loss.kind]} its setpoint at {loss.t:.1f} s"
    if not found.shares:
        return f"{lost}; none of the known causes explains it."
    first, *others = found.shares
    causes = [_words(one) for one in (first, *(one for one in others if abs(one.share) >= NAMED * loss.size))]
    if found.rest >= NAMED * loss.size:
        causes.append(f"{centimetres(found.rest)} with none of the causes")
    without = f"flown again with only {first.cause} taken out: {centimetres(found.without_first)}"
    return f"{lost}: {', '.join(causes)}; {without}."


def _words(one: CauseShare) -> str:
    """Return a share and its interval; without this where both ends read as the share does."""
    low, share, high = (centimetres(value) for value in (one.low, one.share, one.high))
    interval = "" if low == share == high else f" ({low.removesuffix(' cm')} to {high})"
    return f"{share}{interval} by {one.cause}"
