"""A flight read from a bag: all topics joined by their header stamps."""

from collections.abc import Collection
from pathlib import Path

from q2q_model.bag.reader import BagReader
from q2q_model.bag.storage.bag_path import flight_name
from q2q_model.bag.storage.errors import BagError, warn_of_repairs
from q2q_model.counted import first_of
from q2q_model.flights.flight import FLIGHT_FIELDS, Flight
from q2q_model.flights.joined_flight import flight_from_rows
from q2q_model.signals.layout import SIGNALS
from q2q_model.signals.topic_names import TICK_TOPICS

MOST_TOPICS = 8
"""Most topics of other software that an error names."""


def read_flight(path: Path | str, required: Collection[str] = ("mocap",)) -> Flight:
    """Return the flight in a bag; NaN where nothing was recorded.

    Topics are identified by their base name (`/mocap`, `/room/mocap`). Repairs raise a BagRepairWarning: a
    truncated bag, messages out of order, stamps that repeat or belong to no tick.

    Raises:
        BagError: no bag, a `required` topic missing or empty, two topics of one name, clocks without overlap.
    """
    bag = BagReader(path)
    topics = topics_by_name(bag)
    signals = {topics[topic]: rows for topic, rows in bag.rows(topics).items()}
    for name in required:
        if not signals.get(name):
            counts = {key: sum(one.t.size for one in rows) for key, rows in signals.items()}
            has = ", ".join(f"{key} ({count})" for key, count in counts.items()) or _foreign(bag)
            raise BagError(f"bag {bag.path} has no message on {name}; it has {has}")
    try:
        joined = flight_from_rows(flight_name(path), signals)
    except ValueError as misfit:
        raise BagError(f"bag {bag.path}: {misfit}") from misfit
    warn_of_repairs(bag.repairs + tuple(f"bag {bag.path}: {repair}" for repair in joined.repairs))
    return joined.flight


def _foreign(bag: BagReader) -> str:
    """Return the topics of a bag that has none of q2q, and what reads them."""
    if not bag.topics:
        return "none"
    topics = ", ".join(first_of(sorted(bag.topics), MOST_TOPICS))
    return f"{topics}, which a topic map assigns to vehicles (--topics; in Python topics=)"


def topics_by_name(bag: BagReader) -> dict[str, str]:
    """Return the bag's topics that belong to a flight, each with its base name.

    Raises:
        BagError: two topics of one name.
    """
    found: dict[str, str] = {}
    for topic, type_name in bag.topics.items():
        name = topic.rsplit("/", 1)[-1]
        if name not in FLIGHT_FIELDS or SIGNALS.get(type_name) is not TICK_TOPICS[name]:
            continue
        if name in found.values():
            raise BagError(
                f"bag {bag.path} has two topics {name}, {topic} and another; choose one with a topic map"
            )
        found[topic] = name
    return found
