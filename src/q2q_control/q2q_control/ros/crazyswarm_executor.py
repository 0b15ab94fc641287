"""Executor of the flight procedure's orders by the services of Crazyswarm2's server.

| act | service of the server |
|---|---|
| arm, disarm | `all/arm` |
| take off, land | `all/takeoff`, `all/land` |
| stop streaming | `all/notify_setpoints_stop`: until then setpoints override the high-level commander |
| stop the motors | `all/emergency` |
| stream setpoints | none: the stream itself takes over |
"""

import math
from collections.abc import Callable

from builtin_interfaces.msg import Duration
from rclpy.client import Client
from rclpy.node import Node
from rclpy.task import Future
from std_srvs.srv import Empty

from q2q_control.crazyswarm.server_vehicle import ServerVehicle
from q2q_control.flight_procedure.observation import VehicleReport
from q2q_control.flight_procedure.steps import Act, Order
from q2q_control.ros.crazyswarm_types import CRAZYFLIE_PACKAGE, find_types
from q2q_control.ros.server_vehicles import ServerVehicles
from q2q_model.node.reply import Reply
from q2q_model.signals.stamps import stamp_from_time, stamp_parts
from q2q_model.signals.values import Names


class CrazyswarmExecutor:
    """Clients of the server's services, and its vehicles."""

    def __init__(self, node: Node, vehicles: tuple[ServerVehicle, ...]) -> None:
        """Create the clients, and subscribe to the vehicles' topics.

        Raises:
            ImportError: crazyflie_interfaces is missing.
        """
        takeoff, land, arm, stop = find_types(
            CRAZYFLIE_PACKAGE, ("Takeoff", "Land", "Arm", "NotifySetpointsStop"), "srv"
        )
        self._vehicles = ServerVehicles(node, vehicles)
        self._takeoff = node.create_client(takeoff, "all/takeoff")
        self._land = node.create_client(land, "all/land")
        self._arm = node.create_client(arm, "all/arm")
        self._stop = node.create_client(stop, "all/notify_setpoints_stop")
        self._emergency = node.create_client(Empty, "all/emergency")
        self._requests: dict[Act, Callable[[Order], tuple[Client, object]]] = {
            Act.ARM: lambda _: (self._arm, arm.Request(arm=True)),  # type: ignore[attr-defined]
            Act.DISARM: lambda _: (self._arm, arm.Request(arm=False)),  # type: ignore[attr-defined]
            Act.TAKE_OFF: lambda order: (self._takeoff, _timed(takeoff, order)),
            Act.LAND: lambda order: (self._land, _timed(land, order)),
            Act.STOP_STREAM: lambda _: (self._stop, stop.Request()),  # type: ignore[attr-defined]
            Act.EMERGENCY: lambda _: (self._emergency, Empty.Request()),
        }
        self._act, self._asked = Act.EMERGENCY, -math.inf
        self._future: Future[object] | None = None
        self._reply: Reply | None = None

    def begin(self, order: Order, t: float) -> None:
        """Call the service of an order."""
        self._future, self._reply = None, None
        self._act, self._asked = order.act, t
        if order.act not in self._requests:
            self._reply = Reply(granted=True)
            return
        client, request = self._requests[order.act](order)
        if client.service_is_ready():
            self._future = client.call_async(request)
        else:
            words = f"{client.srv_name} is not available: start Crazyswarm2's server"
            self._reply = Reply(granted=False, reason=words)

    def outcome(self, t: float) -> Reply | None:
        """Return the outcome of the last order, once; None while it is unknown.

        The server answers an arming request at once; that vehicles have armed is seen in their status.
        """
        future = self._future
        arming = self._act is Act.ARM and not self._vehicles.armed(self._asked, t)
        if future is not None and future.done() and not arming:
            wrong = future.exception()
            self._reply = Reply(granted=wrong is None, reason="" if wrong is None else str(wrong))
            self._future = None
        reply, self._reply = self._reply, None
        return reply

    def take_sent(self, names: Names) -> None:
        """Take note that a setpoint or command was sent to these vehicles."""
        self._vehicles.take_sent(names)

    def reports(self) -> tuple[VehicleReport, ...]:
        """Return the report of every vehicle; they count as connected while the server runs."""
        return self._vehicles.reports(connected=self._arm.service_is_ready())


def _timed(kind: type, order: Order) -> object:
    whole, rest = stamp_parts(stamp_from_time(order.duration))
    return kind.Request(height=order.height, duration=Duration(sec=whole, nanosec=rest))  # type: ignore[attr-defined]
