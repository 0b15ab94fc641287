"""Executor of the flight procedure's orders by the services of Crazyswarm2's server.

| act | service of the server |
|---|---|
| arm, disarm | `<name>/arm` |
| take off, land | `<name>/takeoff`, `<name>/land` |
| stop streaming | `<name>/notify_setpoints_stop`: until then setpoints override the high-level commander |
| stop the motors | `all/emergency` |
| stream setpoints | none: the stream itself takes over |

The firmware takes the thrust of every RPYT setpoint for 0 until one of thrust 0 has come: in mode command the
first take-off or stream after arming begins with one. It overrides the high-level commander, too, so that a
take-off begins by stopping the stream, and arming alone sends none: another client's take-off would stay on
the ground. A stream follows thrust 0 at once: vehicles in the air fall meanwhile.
"""

import math
from collections.abc import Callable

from rclpy.node import Node
from rclpy.task import Future

from q2q_control.crazyswarm.server_vehicle import ServerVehicle
from q2q_control.flight_procedure.observation import VehicleReport
from q2q_control.flight_procedure.steps import Act, Order
from q2q_control.ros.server_services import ServerServices
from q2q_control.ros.server_vehicles import ServerVehicles
from q2q_model.node.reply import Reply
from q2q_model.signals.values import Names

OVERTAKEN_S = 0.1
"""Time that a setpoint on a topic may arrive after a later service call [s]: assumed."""


class CrazyswarmExecutor:
    """Clients of the server's services, and its vehicles."""

    def __init__(
        self, node: Node, vehicles: tuple[ServerVehicle, ...], unlock: Callable[[], None] | None
    ) -> None:
        """Create the clients, and subscribe to the vehicles' topics.

        Args:
            node: of the clients.
            vehicles: without a report.
            unlock: sends every vehicle an RPYT setpoint of thrust 0; None if full states are flown.

        Raises:
            ImportError: crazyflie_interfaces is missing.
        """
        self._services = ServerServices(node, tuple(one.name for one in vehicles))
        self._vehicles = ServerVehicles(node, vehicles)
        self._unlock, self._locked = unlock, False
        self._unlocked = -math.inf
        self._act: Act | None = None
        self._asked = -math.inf
        self._pending_orders: list[Order] = []
        self._failed = ""
        self._futures: list[Future[object]] = []

    def begin(self, order: Order, t: float) -> None:
        """Unlock the thrust if the order is the first that needs it, then call the order's services."""
        self._act, self._asked = order.act, t
        self._pending_orders = [Order(Act.STOP_STREAM), order] if order.act is Act.TAKE_OFF else [order]
        self._failed, self._futures = "", []
        self._unlock_before(order.act, t)
        self._call_next(t)

    def outcome(self, t: float) -> Reply | None:
        """Return the outcome of the last order, once; None while it is unknown.

        The server answers an arming request at once; that vehicles have armed is seen in their status.
        """
        if self._act is None:
            return None
        self._call_next(t)
        arming = self._act is Act.ARM and not self._vehicles.armed(self._asked, t)
        if not self._failed and (self._pending_orders or arming or not self._answered()):
            return None
        self._act = None
        return Reply(granted=not self._failed, reason=self._failed)

    def take_sent(self, names: Names) -> None:
        """Take note that a setpoint or command was sent to these vehicles."""
        self._vehicles.take_sent(names)

    def reports(self) -> tuple[VehicleReport, ...]:
        """Return the report of every vehicle; one counts as connected while the server has its services."""
        return self._vehicles.reports(connected=self._services.armable())

    def refusal(self) -> str:
        """Return which services of a flight are missing, and what to do; empty if none are."""
        return self._services.missing()

    def _unlock_before(self, act: Act, t: float) -> None:
        """Send thrust 0 before the first take-off or stream since the vehicles were armed."""
        if act is Act.ARM:
            self._locked = True
        elif self._locked and act in {Act.TAKE_OFF, Act.STREAM} and self._unlock is not None:
            self._unlock()
            self._locked, self._unlocked = False, t

    def _call_next(self, t: float) -> None:
        """Call the services of the pending orders, one after the other, unless one fails."""
        early = self._act is Act.TAKE_OFF and t - self._unlocked < OVERTAKEN_S
        while self._answered() and self._pending_orders and not self._failed and not early:
            order = self._pending_orders.pop(0)
            self._failed = self._services.missing((order.act,))
            self._futures = self._services.call(order)

    def _answered(self) -> bool:
        """Return whether all calls are answered; keep why one failed."""
        wrong = (one.exception() for one in self._futures if one.done())
        self._failed = self._failed or next((str(one) for one in wrong if one is not None), "")
        return all(one.done() for one in self._futures)
