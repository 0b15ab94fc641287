"""Subscriptions to what Crazyswarm2's server publishes of its vehicles, as far as it is configured to.

| what | from | published if |
|---|---|---|
| battery, arming | `<name>/status` | crazyflies.yaml has `default_topics: status` |
| estimate | `<name>/onboard` (LogDataGeneric) | it has a custom topic `onboard`: stateEstimate.x, y, z |
| controller, thrust scale | parameters `<name>.params.*` | server.yaml: query_all_values_on_connect |

The parameters that crazyflies.yaml sets are known without the server.
"""

from collections.abc import Sequence
from functools import partial
from time import monotonic
from typing import Protocol

from rcl_interfaces.msg import ParameterType, ParameterValue
from rcl_interfaces.srv import GetParameters
from rclpy.node import Node
from rclpy.task import Future

from q2q_control.crazyswarm.reported_vehicles import ReportedVehicles
from q2q_control.crazyswarm.server_vehicle import ServerVehicle
from q2q_control.flight_procedure.observation import VehicleReport
from q2q_control.ros.crazyswarm_types import CRAZYFLIE_PACKAGE, find_types
from q2q_model.ros.topics.qos import OUTSIDE
from q2q_model.signals.values import Names

SERVER = "crazyflie_server"
ONBOARD = "onboard"
"""Custom topic with a vehicle's own estimate; the mocap filter publishes `pose` and `odom`, too."""


class StatusMessage(Protocol):
    """crazyflie_interfaces/msg/Status."""

    supervisor_info: int
    battery_voltage: float


class LogMessage(Protocol):
    """crazyflie_interfaces/msg/LogDataGeneric."""

    values: Sequence[float]


class ServerVehicles:
    """Subscriptions to the server's vehicles, and pending reads of their parameters."""

    def __init__(self, node: Node, vehicles: tuple[ServerVehicle, ...]) -> None:
        """Subscribe to the vehicles' topics.

        Raises:
            ImportError: crazyflie_interfaces is missing.
        """
        self._vehicles = ReportedVehicles(vehicles)
        status, log = find_types(CRAZYFLIE_PACKAGE, ("Status", "LogDataGeneric"))
        self._parameters = node.create_client(GetParameters, f"{SERVER}/get_parameters")
        self._answers: list[tuple[ServerVehicle, Future[GetParameters.Response]]] = []
        for one in vehicles:
            node.create_subscription(status, f"{one.name}/status", partial(_take_status, one), OUTSIDE)
            node.create_subscription(log, f"{one.name}/{ONBOARD}", partial(_take_estimate, one), OUTSIDE)

    def reports(self, *, connected: Names) -> tuple[VehicleReport, ...]:
        """Return the report of every vehicle; read the server's parameters when they are due."""
        now = monotonic()
        for one, future in self._answers:
            if future.done() and future.exception() is None:
                one.take_parameters(_known(one, future.result().values))
        self._answers = [answer for answer in self._answers if not answer[1].done()]
        if self._parameters.service_is_ready() and self._vehicles.poll_read(now):
            self._answers = [
                (one, self._parameters.call_async(_question(one))) for one in self._vehicles.vehicles
            ]
        return self._vehicles.reports(now, connected=connected)

    def take_sent(self, names: Names) -> None:
        """Take note that a setpoint or command was sent to these vehicles."""
        now = monotonic()
        for one in self._vehicles.vehicles:
            if one.name in names:
                one.take_sent(now)

    def armed(self, ordered: float, t: float) -> bool:
        """Return whether all vehicles have armed since time `ordered` [s]."""
        return self._vehicles.armed(ordered, t)


def _question(one: ServerVehicle) -> GetParameters.Request:
    return GetParameters.Request(names=[f"{one.name}.params.{name}" for name in one.read])


def _known(one: ServerVehicle, values: Sequence[ParameterValue]) -> dict[str, float]:
    """Return the parameters in an answer; it is empty if the server does not know one of them."""
    known: dict[str, float] = {}
    for name, value in zip(one.read, values, strict=False):
        if value.type == ParameterType.PARAMETER_DOUBLE:
            known[name] = value.double_value
        elif value.type == ParameterType.PARAMETER_INTEGER:
            known[name] = float(value.integer_value)
    return known


def _take_status(one: ServerVehicle, status: StatusMessage) -> None:
    one.take_status(status.battery_voltage, status.supervisor_info, monotonic())


def _take_estimate(one: ServerVehicle, log: LogMessage) -> None:
    one.take_estimate(log.values, monotonic())
