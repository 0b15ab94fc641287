"""Recording node: writes the serialised messages of a flight's topics into a rosbag2 MCAP bag.

If the disk is full, the node logs this, stops recording and exits with status 2 once it is ended. Until then
its services answer, so that the flight is completed.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from time import time_ns

from rclpy.event_handler import (
    QoSRequestedIncompatibleQoSInfo,
    SubscriptionEventCallbacks,
)
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSPolicyKind, QoSProfile, ReliabilityPolicy
from rclpy.validate_topic_name import validate_topic_name

from q2q_model.bag import BagWriter, OfferedQos, facts_from_text
from q2q_model.ros.node.bus_node import bus_of
from q2q_model.ros.node.diagnostics_publisher import publish_health
from q2q_model.ros.node.node_parameters import declare
from q2q_model.ros.node.run import run
from q2q_model.ros.topics.message_class import message_class
from q2q_model.ros.topics.qos import RECORD, RECORD_BEST_EFFORT, RECORD_LATCHED
from q2q_model.tunable import check_bounds, tunable
from q2q_sim.flight_bag.recorded_bag import RecordedBag
from q2q_sim.flight_bag.recorded_topics import check_distinct, other_types_note, recorded_types
from q2q_sim.flight_bag.topics import TYPE_NAMES, is_latched


@dataclass(frozen=True, slots=True)
class RecordParams:
    """Parameters of the node."""

    bag: str = tunable("", "bag folder to write, which must not exist", read_only=True)
    topics: tuple[str, ...] = tunable((), "q2q topics to record; empty: all of them", read_only=True)
    extra: tuple[str, ...] = tunable(
        (), "other topics to record, each as topic:package/msg/Type", read_only=True
    )
    stamps: str = tunable(
        "receive",
        "time of a message in the bag: time of receipt (receive), or stamp of its header (header)",
        choices=("receive", "header"),
        read_only=True,
    )
    compression: str = tunable("zstd", "compression of the bag", choices=("zstd", "none"), read_only=True)
    facts: tuple[str, ...] = tunable(
        (), "metadata of the flight, each as name=value, e.g. vehicle=crazyflie_2_1", read_only=True
    )

    def __post_init__(self) -> None:
        """Check the bounds."""
        check_bounds(self)


class Recorder:
    """Subscriptions and the bag that they fill."""

    def __init__(self, node: Node) -> None:
        params = declare(node, RecordParams())
        if not params.bag:
            raise ValueError("parameter bag is empty: give the folder to write, e.g. -p bag:=out/my_flight")
        self._node = node
        self._take_latched: dict[str, Callable[[], None]] = {}
        """How to subscribe again to a topic that is not known to be latched."""
        by_header = params.stamps == "header"
        facts = facts_from_text(params.facts)
        types = recorded_types(params.topics, params.extra, by_header=by_header)
        classes = {topic: message_class(kind) for topic, kind in types.items()}
        for topic in types:
            validate_topic_name(topic)  # before the bag's folder is made: resolve_topic_name raises RCLError
        names = {topic: node.resolve_topic_name(topic) for topic in types}
        check_distinct(names)
        asked = types if params.topics else types.keys() - TYPE_NAMES
        self._asked = sorted(names[topic] for topic in asked)
        writer = BagWriter(Path(params.bag), facts=facts, compress=params.compression == "zstd")
        self.bag = RecordedBag(writer, partial(_offered, node), None if by_header else time_ns)
        bus = bus_of(node)
        for topic, kind in types.items():
            whole = names[topic]
            if bus.carries(topic) or is_latched(topic, kind):
                self.bag.add_topic(whole, kind, latched=is_latched(topic, kind))
            else:
                self.bag.add_foreign(whole, kind)
            if bus.carries(topic):
                bus.listen(topic, partial(self.bag.take_signal, whole))
            else:
                self._subscribe(node, topic, classes[topic], RECORD)
        self._types = {names[topic]: kind for topic, kind in types.items()}
        publish_health(node, self.bag.health, self._look_at_silent)

    def close(self) -> None:
        """Close the bag; raise BagError if its disk took no more."""
        self.bag.close(self._asked)

    def _subscribe(self, node: Node, topic: str, kind: type, qos: QoSProfile) -> None:
        """Record a topic; with `RECORD` until all publishers latch it, or one offers best effort only."""
        whole = node.resolve_topic_name(topic)

        def take_anew(offered: QoSProfile) -> None:
            if node.destroy_subscription(subscription):  # else another event did
                self._subscribe(node, topic, kind, offered)

        def take_less(refused: QoSRequestedIncompatibleQoSInfo) -> None:
            if refused.last_policy_kind == QoSPolicyKind.DURABILITY:
                take_anew(RECORD)
                return
            node.get_logger().info(f"{whole} is sent best effort and recorded that way")
            take_anew(RECORD_BEST_EFFORT)

        events = SubscriptionEventCallbacks(
            message_lost=lambda lost: self.bag.count_lost(whole, lost.total_count),
            incompatible_qos=None if qos is RECORD_BEST_EFFORT else take_less,
        )
        subscription = node.create_subscription(
            kind, topic, partial(self.bag.take, whole), qos, raw=True, event_callbacks=events
        )
        self._take_latched.pop(whole, None)
        if qos is RECORD:
            self._take_latched[whole] = partial(take_anew, RECORD_LATCHED)

    def _look_at_silent(self) -> Mapping[str, str]:
        """Subscribe again, as latched, to silent topics whose publishers latch; return no values.

        Report those that are published with another type.
        Once a second: an event of the match would come at once, but to take one can block the process for
        ever (ros2/rmw_fastrtps#890).
        """
        silent = self._take_latched.keys() - self.bag.received  # of others, the last message would come again
        for topic in sorted(silent):
            if _is_latched(self._node, topic):
                self._take_latched[topic]()
            self._report_other_types(topic)
        return {}

    def _report_other_types(self, topic: str) -> None:
        """Report, once for the same types, that a silent topic is published with others than its own."""
        published = [one.topic_type for one in self._node.get_publishers_info_by_topic(topic)]
        if not published:  # what they had is said at the end
            return
        before = self.bag.other_types.pop(topic, "")
        if note := other_types_note(topic, self._types[topic], published):
            self.bag.other_types[topic] = note
            if note != before:
                self._node.get_logger().warning(note)


def _offered(node: Node, topic: str) -> OfferedQos:
    """Return what all publishers of a topic offer."""
    found = {one.qos_profile.reliability for one in node.get_publishers_info_by_topic(topic)}
    return OfferedQos(ReliabilityPolicy.BEST_EFFORT not in found, _is_latched(node, topic))


def _is_latched(node: Node, topic: str) -> bool:
    """Return whether a topic has publishers, all of which send their last messages to late subscribers."""
    offered = {one.qos_profile.durability for one in node.get_publishers_info_by_topic(topic)}
    return offered == {DurabilityPolicy.TRANSIENT_LOCAL}


def main() -> None:
    """Run the node `bag_record`."""
    run("bag_record", Recorder, Recorder.close)
