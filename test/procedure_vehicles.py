"""Rooms whose vehicles `radio` or `crazyswarm` fly, over cflib's encoders, for tests of the procedure."""

import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
import pytest

pytest.importorskip("cflib", reason="cflib is not installed: requirements/radio.txt has it")
pytest.importorskip("q2q_msgs", reason="the workspace is not built")
from cflib.crazyflie.commander import Commander
from cflib.crazyflie.high_level_commander import HighLevelCommander
from cflib.crazyflie.localization import Localization
from cflib.crazyflie.supervisor import Supervisor
from procedure_room import ProcedureRoom
from rcl_interfaces.msg import ParameterType, ParameterValue
from rcl_interfaces.srv import GetParameters

from q2q_control.crazyswarm.message_conversion import NamedPose
from q2q_control.flight_procedure.steps import Call, Step
from q2q_control.flight_procedure.supervisor_info import READY
from q2q_control.radio import radio_vehicles
from q2q_control.radio.firmware_params import first_difference
from q2q_control.radio.link import CflibSender, LinkHealth, OnboardPose
from q2q_control.ros import procedure_services, radio_topics, radio_wiring, server_vehicles
from q2q_control.ros.crazyswarm_bridge import Crazyswarm
from q2q_control.ros.crazyswarm_types import find_pose_types
from q2q_control.ros.radio_wiring import RadioNode
from q2q_model.ros.topics.messages import header_at
from q2q_model.signals.values import MocapFrame
from q2q_model.trajectory.polynomials import SwarmPlan
from q2q_model.vehicle.hover_thrust import OWN_PARAMETERS, OwnHover
from q2q_planner.offline.minimum_snap.minimum_snap import minimum_snap_plan
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints, Waypoint
from q2q_sim.firmware.firmware import Firmware
from q2q_sim.firmware.supervisor.info import Info
from q2q_sim.ros.absent_packages import interface_packages
from q2q_sim.scenarios import library

SCENARIO = "table6"
NAMES = ("cf1", "cf2")
SHORT = minimum_snap_plan(
    [
        VehicleWaypoints("cf1", (Waypoint(0.0, (0.0, 0.0, 0.8)), Waypoint(3.0, (0.0, 0.0, 1.0)))),
        VehicleWaypoints("cf2", (Waypoint(0.0, (0.0, 2.0, 1.0)), Waypoint(3.0, (0.0, 1.5, 1.0)))),
    ]
)
"""A plan of 3 s."""
WRONG = {
    Step.CHECKED: (Call.FLY, Call.HOLD, Call.LAND),
    Step.HOVER: (Call.TAKE_OFF, Call.START, Call.HOLD),
    Step.FLIGHT: (Call.TAKE_OFF, Call.START, Call.FLY),
    Step.HOLD: (Call.TAKE_OFF, Call.START, Call.HOLD),
}
"""Calls at the wrong time: what each step in which vehicles wait or follow the plan refuses."""


@dataclass(frozen=True)
class Link(CflibSender):
    """cflib's encoders on a simulated vehicle, and the vehicle's own word on its health."""

    firmware: Firmware
    params: Mapping[str, float]
    """What is set once connected."""
    reported: dict[str, object] = field(default_factory=dict)
    """What is reported in place of the truth."""

    @property
    def pose(self) -> OnboardPose:
        """Return the true pose as the vehicle's estimate."""
        x, y, z = self.firmware.rows.pos.tolist()
        return OnboardPose((x, y, z), (0.0, 0.0, 0.0, 1.0))

    def health(self) -> LinkHealth:
        """Return what the vehicle reports of itself."""
        bits = self.firmware.info
        truth = LinkHealth(
            connected=True,
            volt=self.firmware.battery.volt,
            armed=bits & READY == READY,
            locked=bool(bits & Info.LOCKED),
            flying=bool(bits & Info.FLYING),
            onboard=self.pose.pos,
            wrong=first_difference(
                self.params, {name: float(self.firmware.parameters[name]) for name in self.params}
            ),
            own_hover=OwnHover(*(float(self.firmware.parameters[name]) for name in OWN_PARAMETERS)),
        )
        return replace(truth, **self.reported)

    def keep_open(self) -> None:
        """Stay open."""

    def log_lines(self) -> list[str]:
        """Return nothing: the vehicle logs nothing."""
        return []

    def close(self) -> None:
        """End."""


@dataclass
class Flown:
    """A room, and the links by which `radio` flies its vehicles."""

    room: ProcedureRoom
    links: dict[str, Link] = field(default_factory=dict)


def by_radio(monkeypatch: pytest.MonkeyPatch, plan: SwarmPlan | None = None, **given: object) -> Flown:
    """Return a room whose vehicles `radio` flies over cflib's encoders."""
    room = ProcedureRoom(library.load(SCENARIO), monkeypatch, plan, auto_arming=False)
    flown = Flown(room)

    def link(name: str, _: str, params: Mapping[str, float], __: str) -> Link:
        row = NAMES.index(name)
        wire, firmware = room.wire(row), room.fleet.vehicles[row].firmware
        for parameter, value in params.items():
            firmware.parameters.set(parameter, value)
        parts = Commander(wire), HighLevelCommander(wire), Localization(wire), Supervisor(wire)
        return flown.links.setdefault(name, Link(*parts, firmware, params))

    monkeypatch.setattr(radio_vehicles, "CflibLink", link)
    monkeypatch.setattr(radio_topics.RadioTopics, "other_radios", lambda _: "")
    monkeypatch.setattr(radio_topics.RadioTopics, "publish", lambda *_: None)
    room.clock(radio_wiring, procedure_services)
    uris = tuple(f"udp://127.0.0.1:{19850 + k}" for k in range(2))
    vehicle = room.scenario.vehicle.name
    room.start("radio", {"vehicles": NAMES, "uris": uris, "vehicle": vehicle, **given}, RadioNode, {})
    return flown


@dataclass
class Server:
    """Crazyswarm2's server, as far as the procedure goes: cflib's encoders behind its services and topics."""

    room: ProcedureRoom
    ignore_signals: set[str] = field(default_factory=set)
    """Services that answer and do nothing."""
    reports: set[str] = field(default_factory=lambda: {"status", "onboard", "parameters"})
    """What it was set up to report."""
    offset: float = 0.0
    """Of the estimates from the truth [m]."""
    held: dict[str, float] = field(default_factory=dict)
    """Parameters that it reports in place of the vehicles'."""
    bridge: Crazyswarm | None = None
    """Node that asks it."""

    def __post_init__(self) -> None:
        """Connect to the vehicles and choose their controller."""
        wires = [self.room.wire(row) for row in range(2)]
        self._commanders = [Commander(wire) for wire in wires]
        self._high = [HighLevelCommander(wire) for wire in wires]
        self._supervisors = [Supervisor(wire) for wire in wires]
        for vehicle in self.room.fleet.vehicles:
            vehicle.firmware.parameters.set("stabilizer.controller", 2.0)

    def services(self) -> dict[str, Callable[[object], object]]:
        """Return its services by name."""
        acts: dict[str, Callable[[int, object], None]] = {
            "takeoff": lambda k, one: self._high[k].takeoff(one.height, one.duration.sec),
            "land": lambda k, one: self._high[k].land(one.height, one.duration.sec),
            "arm": lambda k, one: self._supervisors[k].send_arming_request(do_arm=one.arm),
            "notify_setpoints_stop": lambda k, _: self._commanders[k].send_notify_setpoint_stop(),
        }
        served: dict[str, Callable[[object], object]] = {
            f"{vehicle}/{name}": self._serve(name, act, (row,))
            for row, vehicle in enumerate(NAMES)
            for name, act in acts.items()
        }
        stop = self._serve("emergency", lambda k, _: self._supervisors[k].send_emergency_stop(), (0, 1))
        return served | {"all/emergency": stop, "crazyflie_server/get_parameters": self._parameters}

    def _parameters(self, request: GetParameters.Request) -> GetParameters.Response:
        """Answer as rclcpp does: nothing at all where one of the parameters has no value."""
        if "parameters" not in self.reports:
            return GetParameters.Response()
        return GetParameters.Response(values=[self._value(name) for name in request.names])

    def _value(self, asked: str) -> ParameterValue:
        vehicle, _, parameter = asked.partition(".params.")
        firmware = self.room.fleet.vehicles[NAMES.index(vehicle)].firmware
        value = self.held.get(parameter, float(firmware.parameters[parameter]))
        if parameter.startswith("stabilizer."):
            return ParameterValue(type=ParameterType.PARAMETER_INTEGER, integer_value=int(value))
        return ParameterValue(type=ParameterType.PARAMETER_DOUBLE, double_value=value)

    def full_state(self, row: int, message: object) -> None:
        """Send a vehicle the setpoint of a message."""
        where, how, acc = message.pose.position, message.twist.linear, message.acc
        turn = message.pose.orientation
        self.room.log.append("cmd_full_state")
        self._commanders[row].send_full_state_setpoint(
            (where.x, where.y, where.z), (how.x, how.y, how.z), (acc.x, acc.y, acc.z),
            (turn.x, turn.y, turn.z, turn.w), 0.0, 0.0, message.twist.angular.z,
        )  # fmt: skip

    def publish(self) -> None:
        """Publish what the server logs of its vehicles."""
        assert self.room.node is not None
        kinds = sys.modules["crazyflie_interfaces.msg"]
        for vehicle in self.room.fleet.vehicles:
            firmware, takers = vehicle.firmware, self.room.node.takers
            status = kinds.Status(supervisor_info=firmware.info, battery_voltage=firmware.battery.volt)
            x, y, z = firmware.rows.pos.tolist()
            onboard = kinds.LogDataGeneric(values=[x, y + self.offset, z])
            for topic, message in (("status", status), ("onboard", onboard)):
                take = takers.get(f"{vehicle.name}/{topic}")
                if take and topic in self.reports:
                    take(message)

    def _serve(
        self, name: str, act: Callable[[int, object], None], rows: tuple[int, ...]
    ) -> Callable[[object], object]:
        def serve(request: object) -> object:
            self.room.log.append(name)
            for row in rows:
                if name not in self.ignore_signals:
                    act(row, request)
            return object()

        return serve


def by_bridge(
    monkeypatch: pytest.MonkeyPatch,
    plan: SwarmPlan | None = None,
    *,
    version: int = 1,
    absent: str = "",
    **given: object,
) -> tuple[ProcedureRoom, Server]:
    """Return a room whose vehicles Crazyswarm2's server flies, but for an absent service, and the server."""
    for name, module in interface_packages().items():
        monkeypatch.setitem(sys.modules, name, module)
    room = ProcedureRoom(library.load(SCENARIO), monkeypatch, plan, auto_arming=False)
    server = Server(room)
    room.clock(server_vehicles, procedure_services)
    asked = {
        "vehicles": NAMES,
        "poses_version": version,
        "poses_out": "/poses_filtered",
        "vehicle": room.scenario.vehicle.name,
        **given,
    }
    offered = {name: serve for name, serve in server.services().items() if name != absent}
    server.bridge = room.start("crazyswarm", asked, Crazyswarm, offered)
    assert room.node is not None
    for row, name in enumerate(NAMES):
        room.node.forward[f"{name}/cmd_full_state"] = lambda message, row=row: server.full_state(row, message)
    types = find_pose_types(version)

    def see(frame: MocapFrame, stamp_ns: int) -> None:
        rows = zip(frame.names, frame.pos.tolist(), frame.quat.tolist(), strict=True)
        poses = [NamedPose(name, tuple(pos), tuple(quat)) for name, pos, quat in rows]
        room.node.takers["/poses"](types.write(header_at(stamp_ns), poses))
        if room.room.tick % 50 == 0:
            server.publish()

    room.mocap = see
    return room, server


def refused(room: ProcedureRoom, step: Step) -> None:
    """Make every call at the wrong time of a step; each is refused at once, with the step's name."""
    for call in WRONG[step]:
        reply = room.call(call, patience=0.0)
        assert not reply.granted
        assert f"the step is {step.value}" in reply.reason


TABLE6_ENDS, SHORT_ENDS = (50.0, [1.5, 2.0]), (3.0, [1.0, 1.0])
"""Duration [s] of a plan and the heights [m] at its end."""


def fly_plan(room: ProcedureRoom, duration: float, heights: list[float]) -> None:
    """Fly a plan from the ground to its end, with every call at the wrong time on the way."""
    refused(room, Step.CHECKED)
    assert room.call(Call.TAKE_OFF).granted, room.node.lines[-5:]
    np.testing.assert_allclose(room.height[-1], 0.5, atol=0.15)
    refused(room, Step.HOVER)
    fly = room.call(Call.FLY)
    assert (fly.granted, fly.reason) == (True, f"the plan has started and takes {duration} s")
    room.wait(0.5 * duration)
    refused(room, Step.FLIGHT)
    room.wait(0.5 * duration + 1.0)
    refused(room, Step.HOLD)
    np.testing.assert_allclose(room.height[-1], heights, atol=0.1)


def land(room: ProcedureRoom) -> None:
    """Land, and see vehicles on the ground, disarmed and checked again."""
    reply = room.call(Call.LAND)
    assert reply.granted
    assert "; disarmed" in reply.reason
    assert not any(one.firmware.supervisor.armed for one in room.fleet.vehicles)
    assert room.height[-1].max() < 0.02
    assert room.node.lines[-1] == "step checked" or room.wait(1.1) is None
