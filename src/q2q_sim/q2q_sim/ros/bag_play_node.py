"""Bag playback node: publishes a bag's messages at a given rate, or tick by tick in lockstep.

The node exits at the end of the bag.
"""

import sys
from collections.abc import Mapping
from pathlib import Path
from time import monotonic

from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.subscription import Subscription
from rosgraph_msgs.msg import Clock
from std_msgs.msg import String
from std_srvs.srv import Trigger

from q2q_model.bag import BagReader, MappedBag, RawMessage, load_topic_map
from q2q_model.diagnostics.health import Health
from q2q_model.ros.node.diagnostics_publisher import publish_health
from q2q_model.ros.node.node_parameters import declare
from q2q_model.ros.node.publisher_conflicts import PublisherConflicts
from q2q_model.ros.node.run import finish, run
from q2q_model.ros.node.steady_timer import steady_timer
from q2q_model.ros.topics.message_class import message_class
from q2q_model.ros.topics.messages import header_at
from q2q_model.ros.topics.qos import LATCHED, TICK, TICK_WRITER
from q2q_model.signals.topic_names import PLAYBACK_OVER
from q2q_sim.bag_playback.awaited_tick import AwaitedTick, awaited_type, check_awaited, played_tick_topics
from q2q_sim.bag_playback.play_params import PlayParams
from q2q_sim.bag_playback.playback import PAUSE_S, Playback
from q2q_sim.bag_playback.played_messages import PlayedMessages, check_start, played_topics
from q2q_sim.bag_playback.subscriber_wait import SubscriberWait
from q2q_sim.bag_playback.tick_messages import TickMessages
from q2q_sim.flight_bag.topics import has_one_writer

CLOCK = "/clock"
ANSWER = "answer"
"""Doubt of a tick that is not answered."""
LOOK_S = 0.1
"""Period of the check for unanswered ticks [s]."""
ACKNOWLEDGE_S = 10.0
"""Longest wait at the end of the bag for readers that have not taken every message [s]."""
MATCH_S = 0.05
"""Period of the check for matched subscribers before the start [s]."""
BEAT_S = 0.001
"""Period of the check for due messages [s]."""


class Player:
    """Bag, publishers and playback position."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._params = declare(node, PlayParams())
        if not self._params.bag:
            raise ValueError("parameter bag is empty: give the folder to play, e.g. -p bag:=bags/table2_1")
        self._reader = _opened(self._params)
        for repair in self._reader.repairs:
            node.get_logger().warning(repair)
        wanted = played_topics(self._reader.topics, self._params.topics)
        if self._params.clock:  # that of the playback, not the recorded one
            wanted.pop(CLOCK, None)
        check_awaited(self._params.wait_for, wanted)
        self._ticks, self._tick_topics = AwaitedTick(), played_tick_topics(wanted, self._params.wait_for)
        waited = self._tick_topics if self._params.wait_for else set(wanted)
        check_start(self._reader, waited, self._params.start)
        self._messages = PlayedMessages(self._reader, wanted, self._params.start)
        self._tick_messages = TickMessages(self._messages, self._tick_topics)
        self._writers = {topic: self._writer(topic, kind) for topic, kind in wanted.items()}
        self._clock = node.create_publisher(Clock, CLOCK, TICK) if self._params.clock else None
        self._over = node.create_publisher(String, PLAYBACK_OVER, LATCHED)
        self._begun = self._ended = False
        self._health = Health()
        awaited = self._params.wait_for.strip("/")
        given = [CLOCK] * self._params.clock + [awaited] * bool(awaited)
        played = [topic.strip("/") for topic in wanted if has_one_writer(topic)]
        self._conflicts = PublisherConflicts(node, (*given, *played), self._health)
        publish_health(node, self._health, self._look)
        self._playback, self._beat = Playback(0, 0.0, self._params.rate), monotonic()
        node.create_service(Trigger, "~/start", self._on_start)
        self._answers: Subscription | None = None
        if self._params.wait_for:
            kind = message_class(awaited_type(self._params.wait_for))
            awaited = self._params.wait_for
            self._answers = node.create_subscription(kind, awaited, self._on_answer, TICK, raw=True)
            steady_timer(node, LOOK_S, self._on_stall)
        else:
            steady_timer(node, BEAT_S, self._on_beat)
        if self._params.autostart:
            self._wait = SubscriberWait(monotonic())
            self._waiting = steady_timer(node, MATCH_S, self._on_wait)

    def _on_wait(self) -> None:
        """Begin once those who read, and who answer, are matched."""
        late = self._writers.keys() - self._messages.latched  # whoever comes late has a latched message
        matches = {topic: self._writers[topic].get_subscription_count() for topic in sorted(late)}
        if self._answers is not None:
            matches[self._params.wait_for] = self._answers.get_publisher_count()
        if not self._begun and not self._wait.update(monotonic(), matches):
            return
        self._waiting.cancel()
        if not self._begun:
            self._node.get_logger().info(self._wait.note())
            self._begin()

    def _look(self) -> Mapping[str, str]:
        """Look for other writers of what this node writes, or waits for; return no values."""
        self._conflicts.update()
        return {}

    def _writer(self, topic: str, kind: str) -> Publisher:
        try:
            found = message_class(kind)
        except ValueError as missing:
            report = (
                f"{topic} holds {kind}, which is not installed here: name the topics to play, e.g. topics"
            )
            raise ValueError(f"{report}:=[mocap]; the bag has {', '.join(self._reader.topics)}") from missing
        quality = LATCHED if topic in self._messages.latched else TICK_WRITER
        return self._node.create_publisher(found, topic.strip("/"), quality)

    def _on_start(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        if self._begun:
            over = "the playback is over: restart the node for another one"
            response.message = over if self._ended else "already playing"
            return response
        self._begin()
        response.success = True
        return response

    def _begin(self) -> None:
        self._begun = True
        self._rewind()
        self._beat = monotonic()
        self._playback = Playback(self._messages.begin_ns, self._beat, self._params.rate)
        if self._params.wait_for:
            self._play_tick()

    def _rewind(self) -> None:
        """Go to the start, and play what was latched before it."""
        self._tick_messages.rewind()
        for message in self._messages.rewind():
            self._writers[message.topic].publish(message.data)

    def close(self) -> None:
        """Raise BagError if the bag is damaged, and has been played up to there only."""
        if self._messages.damage is not None:
            raise self._messages.damage

    def _on_beat(self) -> None:
        now = monotonic()
        pause, self._beat = now - self._beat, now
        if pause > PAUSE_S and self._messages.next is not None:
            self._playback = self._playback.after_pause(pause)
            self._node.get_logger().info(f"stood still for {pause:.1f} s: continues where it was")
        while (message := self._messages.next) is not None and self._playback.due(message.stamp_ns) <= now:
            self._play_next(message)

    def _play_next(self, message: RawMessage) -> None:
        self._play(message)
        self._messages.advance()
        if self._messages.next is None:
            self._end(message.stamp_ns)

    def _on_answer(self, data: bytes) -> None:
        try:
            answered = self._ticks.is_answered_by(data)
        except ValueError as refusal:
            self._health.refuse(f"{self._params.wait_for}: {refusal}")
            return
        if answered:
            self._play_tick()

    def _on_stall(self) -> None:
        again = self._ticks.unanswered(monotonic())
        for message in again:
            self._writers[message.topic].publish(message.data)
        if again:
            unanswered = f"no answer on {self._params.wait_for} to the last tick"
            report = f"{unanswered}: check that the node that writes it runs"
            self._health.doubts[ANSWER] = report
            self._node.get_logger().warning(report, once=True)
            if self._tick_messages.is_over and not self._params.loop:  # its other messages may be cut off
                self._play_tick()

    def _play_tick(self) -> None:
        """Play the messages of the next tick; after the last, end."""
        played = self._tick_messages.take()
        self._ticks.begin(monotonic(), played)
        self._health.doubts[ANSWER] = ""
        for message in played.messages:
            self._play(message)
        if played.tick is None:
            self._end(0)
            if not self._ended:
                self._play_tick()

    def _play(self, message: RawMessage) -> None:
        self._writers[message.topic].publish(message.data)
        if self._clock is not None:
            self._clock.publish(Clock(clock=header_at(message.stamp_ns).stamp))
        self._health.ticks += message.topic in self._tick_topics

    def _end(self, last_ns: int) -> None:
        if self._params.loop and self._messages.damage is None:
            self._rewind()
            self._playback = self._playback.next_round(last_ns, monotonic())
        else:
            self._ended = True
            self._over.publish(String(data=self._params.bag))
            print("playback over", file=sys.stderr)
            self._wait_acknowledged()
            finish(self._node)

    def _wait_acknowledged(self) -> None:
        """Wait until slow readers have every message (lost with their writer), at most ACKNOWLEDGE_S."""
        end = monotonic() + ACKNOWLEDGE_S
        for writer in (*self._writers.values(), self._over):
            writer.wait_for_all_acked(Duration(seconds=max(end - monotonic(), 0.0)))


def _opened(params: PlayParams) -> BagReader | MappedBag:
    """Return the bag to play, with its topics mapped to q2q's if there is a map."""
    if not params.topic_map:
        return BagReader(Path(params.bag))
    return MappedBag(params.bag, load_topic_map(params.topic_map))


def main() -> None:
    """Run the node `bag_play`."""
    run("bag_play", Player, Player.close)
