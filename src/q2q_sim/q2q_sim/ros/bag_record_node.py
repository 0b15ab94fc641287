"""Recording node: the serialised messages of a flight's topics into a rosbag2 MCAP bag.

If the disk takes no more, the node says so, records nothing further, and goes on answering, so that the
flight is flown to its end; its exit status is then 2.
"""

import sys
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from time import time_ns

from rclpy.event_handler import (
    QoSMessageLostInfo,
    QoSRequestedIncompatibleQoSInfo,
    SubscriptionEventCallbacks,
)
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.validate_topic_name import validate_topic_name

from q2q_model.bag import BagError, BagWriter, facts_from_text
from q2q_model.counted import counted
from q2q_model.node.health import Health
from q2q_model.ros.node.bus_node import bus_of
from q2q_model.ros.node.diagnostics import publish_health
from q2q_model.ros.node.node_parameters import declare
from q2q_model.ros.node.run import run
from q2q_model.ros.topics.qos import RECORD, RECORD_BEST_EFFORT
from q2q_model.signals.cdr import encode, header_stamp_ns
from q2q_model.signals.layout import Signal
from q2q_model.signals.local_bus import Listener
from q2q_model.tunable import check_bounds, tunable
from q2q_sim.loop.recorded_topics import recorded_types, told_of_silence
from q2q_sim.loop.topics import TYPE_NAMES


@dataclass(frozen=True, slots=True)
class RecordParams:
    """Parameters of the node."""

    bag: str = tunable("", "folder to write; must not exist", read_only=True)
    topics: tuple[str, ...] = tunable((), "q2q topics to record; empty is all", read_only=True)
    extra: tuple[str, ...] = tunable((), "further topics, each as topic:package/msg/Type", read_only=True)
    stamps: str = tunable("receive", "clock of the bag times", choices=("receive", "header"), read_only=True)
    compression: str = tunable("zstd", "compression of the bag", choices=("zstd", "none"), read_only=True)
    facts: tuple[str, ...] = tunable(
        (), "metadata of the flight, each as name=value, e.g. vehicle=crazyflie_2_1", read_only=True
    )

    def __post_init__(self) -> None:
        """Check the bounds."""
        check_bounds(self)


class Recorder:
    """Bag writer and subscriptions."""

    def __init__(self, node: Node) -> None:
        params = declare(node, RecordParams())
        if not params.bag:
            raise ValueError("parameter bag is empty: give the folder to write, e.g. -p bag:=out/my_flight")
        self.health = Health()
        """Messages stored (ticks) and lost (missed)."""
        self._lost: dict[str, int] = {}
        self.is_full = False
        """Whether the disk has taken no more."""
        self._by_header = params.stamps == "header"
        facts = facts_from_text(params.facts)
        types = recorded_types(params.topics, params.extra, by_header=self._by_header)
        classes = {topic: _class_of(kind) for topic, kind in types.items()}
        for topic in types:
            validate_topic_name(topic)  # before the bag's folder is made: resolve_topic_name raises RCLError
        asked = types if params.topics else types.keys() - TYPE_NAMES
        self._asked = sorted(node.resolve_topic_name(topic) for topic in asked)
        self._heard: set[str] = set()
        self._writer = BagWriter(Path(params.bag), facts=facts, compress=params.compression == "zstd")
        bus = bus_of(node)
        for topic, kind in types.items():
            whole = node.resolve_topic_name(topic)
            self._writer.add_topic(whole, kind)
            if bus.carries(topic):
                bus.listen(topic, self._storing_signals(whole))
            else:
                self._subscribe(node, topic, classes[topic], RECORD)
        publish_health(node, self.health)

    def _subscribe(self, node: Node, topic: str, kind: type, qos: QoSProfile) -> None:
        """Record a topic; with `RECORD` until a publisher offers no more than best effort."""
        whole = node.resolve_topic_name(topic)

        def take_best_effort(_: QoSRequestedIncompatibleQoSInfo) -> None:
            node.get_logger().info(f"{whole} is sent best effort, and recorded so")
            node.destroy_subscription(subscription)
            self._subscribe(node, topic, kind, RECORD_BEST_EFFORT)

        events = SubscriptionEventCallbacks(
            message_lost=self._counting(whole),
            incompatible_qos=take_best_effort if qos is RECORD else None,
        )
        subscription = node.create_subscription(
            kind, topic, self._storing(whole), qos, raw=True, event_callbacks=events
        )

    def close(self) -> None:
        """Close the bag; name the topics of which messages were lost, and those that never came.

        Raises:
            BagError: the disk took no more, before or now.
        """
        try:
            self._writer.close()
        except BagError as refusal:
            self._give_up(refusal)
        if silence := told_of_silence(self._asked, self._heard):
            print(f"bag_record: {silence}", file=sys.stderr)
        for topic, count in self._lost.items():
            lost = f"lost {counted(count, 'message')} of {topic}"
            print(f"bag_record: {lost}: this machine is too busy", file=sys.stderr)
        if self.is_full:
            raise BagError(f"bag {self._writer.path} lacks what came after its disk took no more")

    def _storing_signals(self, topic: str) -> Listener:
        def take(stamp_ns: int, signal: Signal) -> None:
            self._store(topic, stamp_ns if self._by_header else time_ns(), encode(signal, stamp_ns))

        return take

    def _storing(self, topic: str) -> Callable[[bytes], None]:
        def take(data: bytes) -> None:
            try:
                stamp_ns = header_stamp_ns(data) if self._by_header else time_ns()
            except ValueError as refusal:
                self.health.refuse(f"{topic}: {refusal}; not recorded")
                return
            self._store(topic, stamp_ns, data)

        return take

    def _store(self, topic: str, stamp_ns: int, data: bytes) -> None:
        if self.is_full:
            self.health.missed += 1
            return
        self._heard.add(topic)
        if stamp_ns < 0:
            self.health.refuse(f"{topic}: stamp of {1e-9 * stamp_ns:g} s; bags begin at 0 s; not recorded")
            return
        try:
            self._writer.write_raw(topic, stamp_ns, data)
        except BagError as refusal:
            self._give_up(refusal)
        else:
            self.health.ticks += 1

    def _give_up(self, refusal: BagError) -> None:
        """Record nothing further."""
        self.is_full = True
        self.health.refuse(str(refusal))
        with suppress(OSError):  # a log on the same disk
            print(f"bag_record: {refusal}; nothing more is recorded", file=sys.stderr, flush=True)

    def _counting(self, topic: str) -> Callable[[QoSMessageLostInfo], None]:
        def count(lost: QoSMessageLostInfo) -> None:
            self._lost[topic] = lost.total_count
            self.health.missed = sum(self._lost.values())

        return count


def _class_of(kind: str) -> type:
    package, _, name = kind.split("/")
    try:
        found: type = getattr(import_module(f"{package}.msg"), name)
    except (ImportError, AttributeError) as missing:
        raise ValueError(f"message type {kind} is not installed here") from missing
    return found


def main() -> None:
    """Run the node `bag_record`."""
    run("bag_record", Recorder, Recorder.close)
