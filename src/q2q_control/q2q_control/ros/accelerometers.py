"""Accelerometers of the topic `imu`, for controllers that correct by them."""

from collections.abc import Callable

from rclpy.node import Node

from q2q_model.diagnostics.health import Health
from q2q_model.ros.node.bus_node import bus_of
from q2q_model.ros.topics.messages import MESSAGES
from q2q_model.ros.topics.qos import SENSOR
from q2q_model.ros.topics.subscriptions import listener
from q2q_model.signals.layout import Signal
from q2q_model.signals.values import SwarmImu

IMU = "imu"


def receive_accelerometers(node: Node, take: Callable[[SwarmImu], None], health: Health) -> None:
    """Subscribe to `imu` and call `take` with every message; without any, positions alone correct.

    An invalid message is refused in `health`.
    """

    def forward(_: int, imu: Signal) -> None:
        if isinstance(imu, SwarmImu):
            take(imu)

    bus = bus_of(node)
    if bus.carries(IMU):
        bus.listen(IMU, forward)
    else:
        receive = listener(IMU, SwarmImu, forward, health.refuse)
        node.create_subscription(MESSAGES[SwarmImu], IMU, receive, SENSOR, raw=True)
