"""Executor of the flight procedure's orders by the services of Crazyswarm2's server.

| act | service of the server |
|---|---|
| arm, disarm | `<name>/arm` |
| take off, land | `<name>/takeoff`, `<name>/land` |
| stop streaming | `<name>/notify_setpoints_stop`: until then setpoints override the high-level commander |
| stop the motors | `all/emergency` |
| stream setpoints | none: the stream itself takes over |
"""

import math

from rclpy.node import Node
from rclpy.task import Future

from q2q_control.crazyswarm.server_vehicle import ServerVehicle
from q2q_control.flight_procedure.observation import VehicleReport
from q2q_control.flight_procedure.steps import Act, Order
from q2q_control.ros.server_services import ServerServices
from q2q_control.ros.server_vehicles import ServerVehicles
from q2q_model.node.reply import Reply
from q2q_model.signals.values import Names


class CrazyswarmExecutor:
    """Clients of the server's services, and its vehicles."""

    def __init__(self, node: Node, vehicles: tuple[ServerVehicle, ...]) -> None:
        """Create the clients, and subscribe to the vehicles' topics.

        Raises:
            ImportError: crazyflie_interfaces is missing.
        """
        self._services = ServerServices(node, tuple(one.name for one in vehicles))
        self._vehicles = ServerVehicles(node, vehicles)
        self._act: Act | None = None
        self._asked = -math.inf
        self._failed = ""
        self._futures: list[Future[object]] = []

    def begin(self, order: Order, t: float) -> None:
        """Call the services of an order."""
        self._act, self._asked = order.act, t
        self._failed = self._services.missing((order.act,))
        self._futures = self._services.call(order)

    def outcome(self, t: float) -> Reply | None:
        """Return the outcome of the last order, once; None while it is unknown.

        The server answers an arming request at once; that vehicles have armed is seen in their status.
        """
        if self._act is None or (not self._failed and not self._done(t)):
            return None
        self._act = None
        wrong = (str(one.exception()) for one in self._futures if one.done() and one.exception())
        reason = self._failed or next(wrong, "")
        return Reply(granted=not reason, reason=reason)

    def take_sent(self, names: Names) -> None:
        """Take note that a setpoint or command was sent to these vehicles."""
        self._vehicles.take_sent(names)

    def reports(self) -> tuple[VehicleReport, ...]:
        """Return the report of every vehicle; one counts as connected while the server has its services."""
        return self._vehicles.reports(connected=self._services.armable())

    def refusal(self) -> str:
        """Return which services of a flight are missing, and what to do; empty if none are."""
        return self._services.missing()

    def _done(self, t: float) -> bool:
        arming = self._act is Act.ARM and not self._vehicles.armed(self._asked, t)
        return not arming and all(one.done() for one in self._futures)
