"""Connection of a block to topics: join inputs by stamp, update, publish with that stamp."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from math import inf
from time import perf_counter
from typing import Generic, TypeVar

from rclpy.node import Node

from q2q_model.compiled import COMPILED
from q2q_model.diagnostics.diagnostic_values import diagnostic_values
from q2q_model.diagnostics.health import Health
from q2q_model.diagnostics.stopwatch import Stopwatch
from q2q_model.node.warm_up import warm_up
from q2q_model.ros.node.bus_node import bus_of
from q2q_model.ros.node.diagnostics_publisher import publish_health
from q2q_model.ros.node.publisher_conflicts import PublisherConflicts
from q2q_model.ros.node.signal_publisher import SignalPublisher
from q2q_model.ros.topics.messages import MESSAGES
from q2q_model.ros.topics.qos import TICK, TICK_WRITER
from q2q_model.ros.topics.subscriptions import listener
from q2q_model.signals.layout import Signal
from q2q_model.signals.tick_join import TickJoin
from q2q_model.signals.values import Names

Made = TypeVar("Made", bound=Signal)


class TickWiring(Generic[Made]):
    """Subscriptions and publisher of one block, whose output is a Made."""

    def __init__(
        self,
        node: Node,
        inputs: Mapping[str, type[Signal]],
        output: tuple[str, type[Made]],
        *,
        shares_output: bool = False,
    ) -> None:
        """Declare the output of a block, whose inputs are subscribed to by `start`.

        Args:
            node: owner of publisher and subscriptions.
            inputs: topics and signals that make a tick.
            output: topic and signal of its result.
            shares_output: nodes of other names write the output, too, each for vehicles of its own.
        """
        self.health = Health()
        self._join: TickJoin[Signal] = TickJoin(tuple(inputs))
        self._node = node
        topic, signal = output
        self._publisher = SignalPublisher(node, topic, signal, TICK_WRITER)
        self._inputs = inputs
        self._after: list[Callable[[int, Made], None]] = []
        self._topic = topic
        self._bus = bus_of(node)
        self._last: Made | None = None
        self._may_begin: Callable[[], bool] = _always
        self._held: _HeldTick[Made] | None = None
        self._compiled = 0
        self._watch = Stopwatch(perf_counter)
        self._more: list[Callable[[], Mapping[str, str]]] = []
        self._checks: list[Callable[[], object]] = []
        self.expect_one_publisher(*inputs)
        self.check_each_second(
            PublisherConflicts(node, (topic,), self.health, inf if shares_output else 1).update
        )
        publish_health(node, self.health, self._facts)

    def warm_up(self, update: Callable[..., Made], reset: Callable[[], None], names: Names = ()) -> None:
        """Run the block on synthetic ticks and reset it, so that nothing is compiled or loaded in flight."""
        warm_up(update, reset, self._inputs.values(), names)

    def start(self, update: Callable[..., Made]) -> None:
        """Subscribe to the inputs and call `update` with the signals of every complete tick, in order."""
        for topic, signal in self._inputs.items():
            self._subscribe(topic, signal, update)

    def after_publish(self, follow: Callable[[int, Made], None]) -> None:
        """Call `follow(stamp_ns, signal)` after each publication, off the critical path."""
        self._after.append(follow)

    def hold_until(self, may_begin: Callable[[], bool]) -> None:
        """Hold a complete tick back until `may_begin()` at `resume`, or until its inputs come again."""
        self._may_begin = may_begin

    def resume(self) -> None:
        """Begin the tick that is held back, if it may begin now."""
        if self._held is not None and self._may_begin():
            self._begin(self._held)

    def publish(self, stamp_ns: int, signal: Made) -> None:
        """Publish a signal with a stamp, first to listeners within the process if there is a bus."""
        self._publisher.post(stamp_ns, signal)

    def listen(self, topic: str, take: Callable[[int, Signal], None]) -> None:
        """Call `take(stamp_ns, signal)` for every message of an input, including incomplete ticks."""
        self._bus.listen(topic, take)

    def expect_one_publisher(self, *topics: str) -> None:
        """Report once per second the topics that several nodes write."""
        self.check_each_second(PublisherConflicts(self._node, topics, self.health).update)

    def check_each_second(self, check: Callable[[], object]) -> None:
        """Call `check` before each report on `/diagnostics`: what it finds wrong is for `health`."""
        self._checks.append(check)

    def add_diagnostic_values(self, more: Callable[[], Mapping[str, str]]) -> None:
        """Add the values of `more()` to `/diagnostics`, once per second."""
        self._more.append(more)

    def _facts(self) -> Mapping[str, str]:
        self.health.awaited = self._join.lacking()
        for check in self._checks:
            check()
        found: dict[str, str] = {}
        if self._last is not None:
            found |= {**diagnostic_values(self._last), **self._watch.take_lap_report()}
        for more in self._more:
            found |= more()
        return found

    def _warn_of_compilations(self) -> None:
        """Warn of kernels compiled since the first tick, which warm-up and set-up have missed."""
        if len(COMPILED) > self._compiled:
            late = ", ".join(COMPILED[self._compiled :])
            self._node.get_logger().warning(f"compiled in flight: {late}; run scripts/setup")
            self._compiled = len(COMPILED)

    def _publish_and_follow(self, stamp_ns: int, signal: Made) -> None:
        self._publisher.publish(stamp_ns, signal)
        for follow in self._after:
            follow(stamp_ns, signal)

    def _subscribe(self, topic: str, signal: type[Signal], update: Callable[..., Made]) -> None:
        def take(stamp_ns: int, value: Signal) -> None:
            try:
                self._receive(topic, stamp_ns, value, update)
            except ValueError as refusal:
                self.health.refuse(f"{topic}: {refusal}")

        self._bus.listen(topic, take)
        if self._bus.claim_subscription(topic):
            receive = listener(topic, signal, partial(self._bus.post, topic), self.health.refuse)
            self._node.create_subscription(MESSAGES[signal], topic, receive, TICK, raw=True)

    def _receive(self, topic: str, stamp_ns: int, value: Signal, update: Callable[..., Made]) -> None:
        values = self._join.put(topic, stamp_ns, value)
        self.health.missed = self._join.missed
        if values is None:
            return
        again = self._held is not None and self._held.stamp_ns == stamp_ns
        self._held = _HeldTick(stamp_ns, values, update)
        if again or self._may_begin():
            self._begin(self._held)

    def _begin(self, tick: "_HeldTick[Made]") -> None:
        self._held = None
        if self._last is None:
            self._compiled = len(COMPILED)
        self._watch.restart()
        made = tick.update(*tick.values)
        self._watch.lap()
        self._warn_of_compilations()
        self._last = made
        self.health.ticks += 1
        self._bus.post(
            self._topic, tick.stamp_ns, made, partial(self._publish_and_follow, tick.stamp_ns, made)
        )


@dataclass(frozen=True, slots=True)
class _HeldTick(Generic[Made]):
    """Complete inputs of a tick."""

    stamp_ns: int
    values: tuple[Signal, ...]
    update: Callable[..., Made]


def _always() -> bool:
    return True
