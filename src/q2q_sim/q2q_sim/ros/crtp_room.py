"""CRTP endpoint of a simulator's room, with its clients on `/diagnostics`."""

from dataclasses import dataclass

from rclpy.node import Node

from q2q_model.node.health import Health
from q2q_model.ros.node.node_parameters import declare
from q2q_model.ros.node.steady_timer import steady_timer
from q2q_model.tunable import check_bounds, tunable
from q2q_sim.crtp.fleet import Fleet
from q2q_sim.crtp.fleet_room import CrtpRoomParams, fleet_in
from q2q_sim.crtp.packets.link_model import LinkParams
from q2q_sim.crtp.udp_endpoint import CrtpEndpoint
from q2q_sim.loop.room import Room
from q2q_sim.scenarios.scenario import Scenario

TELL_S = 1.0
"""Period of the diagnostics [s]."""


@dataclass(frozen=True, slots=True)
class CrtpNodeParams:
    """Parameters of the simulator's CRTP endpoint."""

    crtp_port: int = tunable(
        19850, "UDP port of the first vehicle; 0 lets the system choose", low=0, high=65535, read_only=True
    )
    crtp_start: str = tunable(
        "ground",
        "start of the vehicles: on the ground below their first waypoint, or held at it",
        choices=("ground", "air"),
        read_only=True,
    )
    crtp_positioning: str = tunable(
        "deck",
        "positioning of the vehicles: by themselves, by optical flow from their start, or sent by clients",
        choices=("deck", "flow", "external"),
        read_only=True,
    )
    crtp_decks: tuple[str, ...] = tunable(
        ("bcFlow2", "bcZRanger2"), "reported decks besides that for positioning", read_only=True
    )
    crtp_auto_arming: bool = tunable(True, "vehicles arm themselves, as the stock build does", read_only=True)  # noqa: FBT003
    crtp_zero_expires: bool = tunable(
        False,  # noqa: FBT003
        "a setpoint without thrust expires after 0.5 s; the firmware keeps it",
        read_only=True,
    )
    crtp_latency: float = tunable(
        0.0, "latency of the link in each direction", unit="s", low=0.0, high=0.5, read_only=True
    )
    crtp_loss: float = tunable(0.0, "fraction of transmissions lost", low=0.0, high=0.9, read_only=True)
    crtp_rate: float = tunable(
        0.0,
        "packet rate of one radio, both directions; 0 is no limit",
        unit="Hz",
        low=0.0,
        high=1e5,
        read_only=True,
    )
    crtp_per_radio: int = tunable(15, "vehicles that share one radio", low=1, high=1000, read_only=True)

    def __post_init__(self) -> None:
        """Check the bounds."""
        check_bounds(self)


def open_crtp(node: Node, room: Room, scenario: Scenario, health: Health) -> CrtpEndpoint:
    """Return the endpoint of a room before its first tick; its vehicles wait for clients.

    Raises:
        OSError: a port is taken.
    """
    asked = declare(node, CrtpNodeParams())
    waiting = CrtpRoomParams(
        start=asked.crtp_start,
        positioning=asked.crtp_positioning,
        decks=asked.crtp_decks,
        auto_arming=asked.crtp_auto_arming,
        zero_expires=asked.crtp_zero_expires,
    )
    link = LinkParams(
        latency=asked.crtp_latency,
        loss=asked.crtp_loss,
        rate=asked.crtp_rate,
        per_radio=asked.crtp_per_radio,
    )
    fleet = fleet_in(room, scenario, waiting)
    endpoint = CrtpEndpoint(fleet, scenario.names, asked.crtp_port, link)
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
