"""Text on a tube: what is known of it, and in what flights are not fresh ones of its own kind."""

from collections.abc import Sequence
from dataclasses import fields

from q2q_sim.experiments.promise.tracking_tube import TrackingTube, TubeConditions, TubeFlights


def different_conditions(tube: TrackingTube, flown: TubeConditions) -> Sequence[str]:
    """Return the conditions in which flights differ from those of a tube, as text."""
    return [
        f"{one.name} = {getattr(flown, one.name)}, of the tube {getattr(tube.conditions, one.name)}"
        for one in fields(TubeConditions)
        if getattr(tube.conditions, one.name) not in (getattr(flown, one.name), None)
    ]


def reused_seeds(tube: TrackingTube, first: int, count: int) -> str | None:
    """Return which flights, of `count` seeds from `first`, are those that a tube is learned from, as text."""
    of = tube.learned_from
    if of is None or first >= of.first + of.count or of.first >= first + count:
        return None
    last = of.first + of.count - 1
    return (
        f"the tube was learned from seeds {of.first} to {last}, which cannot test it; give --first {last + 1}"
    )


def tube_lines(learned: TrackingTube) -> Sequence[str]:
    """Return what is known of a learned tube as lines of text."""
    size = f"tube at alpha {learned.alpha:g} from {learned.flights} flights: {_size(learned)}"
    of = learned.learned_from
    if of is None:
        return [size]
    if learned.horizontal <= of.horizontal and learned.vertical <= of.vertical:
        kept = f"stay within it with probability {1.0 - learned.alpha:g}"
        return [size, f"it lies within the flown tube: flights with the flown one {kept}"]
    return [size, f"flown with {_size(of)}; run promise with --tube to count how many flights leave it"]


def _size(tube: TrackingTube | TubeFlights) -> str:
    return f"{1e3 * tube.horizontal:.0f} mm horizontally, {1e3 * tube.vertical:.0f} mm vertically"
