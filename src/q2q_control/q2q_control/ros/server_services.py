"""Clients of the services of Crazyswarm2's server, of every vehicle its own.

Those of `all` reach every vehicle of the server, also one that this node does not fly; and up to 1.0.5 the
cflib server has no `all/notify_setpoints_stop`. Only the emergency is for all.
"""

from collections.abc import Sequence

from builtin_interfaces.msg import Duration
from rclpy.node import Node
from rclpy.task import Future
from std_srvs.srv import Empty

from q2q_control.flight_procedure.steps import Act, Order
from q2q_control.ros.crazyswarm_types import CRAZYFLIE_PACKAGE, find_types
from q2q_control.ros.guarded_commands import EMERGENCY
from q2q_model.signals.stamps import stamp_from_time, stamp_parts
from q2q_model.signals.values import Names

SERVICES = {
    "takeoff": ("Takeoff", (Act.TAKE_OFF,)),
    "land": ("Land", (Act.LAND,)),
    "arm": ("Arm", (Act.ARM, Act.DISARM)),
    "notify_setpoints_stop": ("NotifySetpointsStop", (Act.STOP_STREAM,)),
}
"""Services of a vehicle by name: type, and the acts that they execute."""
BEGINS = frozenset({Act.ARM, Act.TAKE_OFF})
"""Acts of which no vehicle is asked unless all can be."""


class ServerServices:
    """Clients of the services of every vehicle."""

    def __init__(self, node: Node, names: Names) -> None:
        """Create the clients.

        Raises:
            ImportError: crazyflie_interfaces is missing.
        """
        self._names = names
        found = find_types(CRAZYFLIE_PACKAGE, [kind for kind, _ in SERVICES.values()], "srv")
        self._types: dict[Act, type] = {Act.EMERGENCY: Empty}
        self._clients = {Act.EMERGENCY: [node.create_client(Empty, EMERGENCY)]}
        for (service, (_, acts)), kind in zip(SERVICES.items(), found, strict=True):
            clients = [node.create_client(kind, f"{name}/{service}") for name in names]
            self._types |= dict.fromkeys(acts, kind)
            self._clients |= dict.fromkeys(acts, clients)

    def missing(self, acts: Sequence[Act] = tuple(Act)) -> str:
        """Return which services of some acts are not available, and what to do; empty if all are."""
        clients = (one for act in acts for one in self._clients.get(act, ()))
        absent = dict.fromkeys(one.srv_name for one in clients if not one.service_is_ready())
        return (
            f"{', '.join(absent)} not available: start Crazyswarm2's server, or update it" if absent else ""
        )

    def armable(self) -> Names:
        """Return the vehicles that the server can arm: those that it has."""
        clients = zip(self._names, self._clients[Act.ARM], strict=True)
        return tuple(name for name, one in clients if one.service_is_ready())

    def call(self, order: Order) -> "list[Future[object]]":
        """Call the services of an order that are offered; of an act that begins a flight, all or none."""
        clients = self._clients.get(order.act, [])
        ready = [one for one in clients if one.service_is_ready()]
        if order.act in BEGINS and len(ready) < len(clients):
            return []
        return [one.call_async(self._request(order)) for one in ready]

    def _request(self, order: Order) -> object:
        kind = self._types[order.act]
        if order.act in {Act.ARM, Act.DISARM}:
            return kind.Request(arm=order.act is Act.ARM)  # type: ignore[attr-defined]
        if order.act in {Act.TAKE_OFF, Act.LAND}:
            whole, rest = stamp_parts(stamp_from_time(order.duration))
            duration = Duration(sec=whole, nanosec=rest)
            return kind.Request(height=order.height, duration=duration)  # type: ignore[attr-defined]
        return kind.Request()  # type: ignore[attr-defined]
