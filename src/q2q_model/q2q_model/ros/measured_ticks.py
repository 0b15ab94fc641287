"""Ticks with state, command and IMU readings of one stamp, joined from their topics."""

from collections.abc import Callable
from functools import partial

from rclpy.node import Node

from q2q_model.ros.topics.messages import MESSAGES
from q2q_model.ros.topics.qos import EVERY_SAMPLE, EVERY_TICK
from q2q_model.ros.topics.subscriptions import listener
from q2q_model.signals.layout import Signal
from q2q_model.signals.tick_join import TickJoin
from q2q_model.signals.values import SwarmCommand, SwarmImu, SwarmState

INPUTS: dict[str, type[Signal]] = {"state": SwarmState, "command": SwarmCommand, "imu": SwarmImu}


def receive_measured_ticks(
    node: Node,
    take: Callable[[SwarmState, SwarmCommand, SwarmImu], object],
    refuse: Callable[[str], None],
) -> TickJoin[Signal]:
    """Subscribe to INPUTS and return their join.

    `take` is called with every complete tick, `refuse` with why a message is invalid.
    After a stall each queue holds up to its depth; the join waits for as many, so that none is lost.
    """
    join: TickJoin[Signal] = TickJoin(tuple(INPUTS), waiting=EVERY_TICK.depth)

    def put(topic: str, stamp_ns: int, signal: Signal) -> None:
        values = join.put(topic, stamp_ns, signal)
        if values is not None:
            take(*values)  # type: ignore[arg-type]  # in INPUTS' order

    for topic, signal in INPUTS.items():
        profile = EVERY_SAMPLE if signal is SwarmImu else EVERY_TICK
        receive = listener(topic, signal, partial(put, topic), refuse)
        node.create_subscription(MESSAGES[signal], topic, receive, profile, raw=True)
    return join
