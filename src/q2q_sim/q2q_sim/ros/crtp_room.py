"""CRTP endpoint of a simulator's room."""

from rclpy.node import Node

from q2q_model.ros.node.node_parameters import declare
from q2q_sim.crtp.fleet_room import CrtpRoomParams, fleet_in, unflown_faults, warm_up_firmware
from q2q_sim.crtp.loopback_ports import PortParams
from q2q_sim.crtp.udp_endpoint import CrtpEndpoint
from q2q_sim.link.shared_radios import SharedRadioParams
from q2q_sim.loop.room import Room
from q2q_sim.scenarios.scenario import Scenario

PREFIX = "crtp_"
"""Of the parameters, which are declared with `crtp` only."""


def open_crtp(node: Node, room: Room, scenario: Scenario) -> CrtpEndpoint:
    """Return the endpoint of a room before its first tick; its vehicles wait for clients.

    Raises:
        OSError: a port is taken.
    """
    warm_up_firmware(scenario)
    port = declare(node, PortParams(), PREFIX).port
    fleet = fleet_in(room, scenario, declare(node, CrtpRoomParams(), PREFIX))
    endpoint = CrtpEndpoint(fleet, port, declare(node, SharedRadioParams(), PREFIX), seed=room.seed)
    if jams := unflown_faults(scenario):
        node.get_logger().warning(jams)
    for name, uri in zip(scenario.names, endpoint.uris, strict=True):
        node.get_logger().info(f"{name} listens at {uri}")
    return endpoint
