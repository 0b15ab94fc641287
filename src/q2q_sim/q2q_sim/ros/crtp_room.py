"""CRTP endpoint of a simulator's room, with its clients on `/diagnostics`."""

from rclpy.node import Node

from q2q_model.node.health import Health
from q2q_model.ros.node.node_parameters import declare
from q2q_model.ros.node.steady_timer import steady_timer
from q2q_sim.crtp.fleet import Fleet
from q2q_sim.crtp.fleet_room import CrtpRoomParams, fleet_in
from q2q_sim.crtp.packets.link_model import LinkParams
from q2q_sim.crtp.udp_endpoint import CrtpEndpoint, PortParams
from q2q_sim.loop.room import Room
from q2q_sim.scenarios.scenario import Scenario

TELL_S = 1.0
"""Period of the diagnostics [s]."""
PREFIX = "crtp_"
"""Of the parameters, which are declared with `crtp` only."""


def open_crtp(node: Node, room: Room, scenario: Scenario, health: Health) -> CrtpEndpoint:
    """Return the endpoint of a room before its first tick; its vehicles wait for clients.

    Raises:
        OSError: a port is taken.
    """
    port = declare(node, PortParams(), PREFIX).port
    fleet = fleet_in(room, scenario, declare(node, CrtpRoomParams(), PREFIX))
    endpoint = CrtpEndpoint(fleet, scenario.names, port, declare(node, LinkParams(), PREFIX))
    for name, uri in zip(scenario.names, endpoint.uris, strict=True):
        node.get_logger().info(f"{name} listens at {uri}")
    steady_timer(node, TELL_S, lambda: _tell(fleet, endpoint, health))
    return endpoint


def rehearse_crtp(scenario: Scenario) -> None:
    """Fly a temporary room by its own firmware for a tick, so that the first real tick is not slow."""
    room = Room(scenario, seed=0)
    room.fly(fleet_in(room, scenario, CrtpRoomParams()).fly)


def _tell(fleet: Fleet, endpoint: CrtpEndpoint, health: Health) -> None:
    passed = endpoint.traffic
    health.extra["crtp_packets"] = f"{passed.received} in, {passed.sent} out, {passed.dropped} dropped"
    for vehicle in fleet.vehicles:
        seen = f"{len(vehicle.clients)} clients, {vehicle.refusals.count} refused"
        last = vehicle.refusals.last
        health.extra[f"crtp_{vehicle.name}"] = f"{seen}: {last}" if last else seen
