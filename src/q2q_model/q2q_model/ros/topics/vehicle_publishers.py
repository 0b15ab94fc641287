"""Publishers of per-vehicle topics such as `<name>/pose`.

Creating one takes a millisecond and triggers discovery in every participant. Publishers of known vehicles
are created before flight, those of new vehicles one vehicle per tick, and none if the rate is 0. Motion
capture names objects as its user likes: one whose name cannot begin a topic has none.
"""

from collections.abc import Mapping
from itertools import chain

from rclpy.node import Node
from rclpy.publisher import Publisher

from q2q_model.node.decimation import Decimation
from q2q_model.ros.topics.subscriber_check import SubscriberCheck
from q2q_model.signals.values import Names
from q2q_model.signals.vehicle_name import LONGEST_SHOWN, VEHICLE_NAME

QUEUE = 10
"""Messages that a publisher keeps for a slow reader: a second at the default rate."""
ASK_EVERY_NS = 500_000_000
"""Interval of the question for subscribers [ns]."""


class VehiclePublishers:
    """One publisher per vehicle and topic, with a common rate limit."""

    def __init__(self, node: Node, topics: Mapping[str, type], rate_hz: float, names: Names = ()) -> None:
        """Publish on `<name>/<topic>` messages of each topic's class.

        Args:
            node: owner of the publishers.
            topics: name and message class of each topic.
            rate_hz: largest rate [Hz]; 0 is none.
            names: vehicles known before flight.
        """
        self._node = node
        self._topics = topics if rate_hz > 0.0 else {}
        self._due = Decimation(rate_hz)
        self._made: dict[str, tuple[Publisher, ...]] = {}
        self._checks: dict[str, SubscriberCheck] = {}
        self._check = SubscriberCheck(())
        self._complete: Names = ()  # all of these have publishers
        for name in names:
            self._make(name)

    def due(self, t: float, stamp_ns: int, names: Names) -> bool:
        """Return whether to publish these vehicles: their time is come, and someone subscribes to one.

        Args:
            t: now [s].
            stamp_ns: the same as a stamp [ns].
            names: publishers of new ones may come later.
        """
        self.create_next(names)
        return self._due(t) and self._check.has_subscribers(stamp_ns)

    def create_next(self, names: Names) -> None:
        """Create the publishers of the first of these vehicles that has none."""
        if names == self._complete:
            return
        new = next((name for name in names if name not in self._made), None)
        if new is None:
            self._complete = names
        else:
            self._make(new)

    def with_subscribers(self, name: str, stamp_ns: int) -> tuple[Publisher, ...]:
        """Return a vehicle's publishers in the order of the topics; none if nobody subscribes to any."""
        check = self._checks.get(name)
        return self._made[name] if check is not None and check.has_subscribers(stamp_ns) else ()

    def _make(self, name: str) -> None:
        make, topics = self._node.create_publisher, self._topics
        if topics and not VEHICLE_NAME.fullmatch(name):
            shown, allowed = name[:LONGEST_SHOWN], "at most 100 letters, digits and _, a letter first"
            self._node.get_logger().warning(f"no {shown!r}/{'|'.join(topics)}: topics have {allowed}")
            topics = {}
        self._made[name] = tuple(make(kind, f"{name}/{topic}", QUEUE) for topic, kind in topics.items())
        self._checks[name] = SubscriberCheck(self._made[name], ASK_EVERY_NS)
        self._check = SubscriberCheck(chain.from_iterable(self._made.values()), ASK_EVERY_NS)
