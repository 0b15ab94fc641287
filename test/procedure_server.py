"""Rooms whose vehicles `crazyswarm` flies by Crazyswarm2's server, over cflib's encoders."""

import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial

import pytest

pytest.importorskip("cflib", reason="cflib is not installed: requirements/radio.txt has it")
pytest.importorskip("q2q_msgs", reason="the workspace is not built")
from cflib.crazyflie.commander import Commander
from cflib.crazyflie.high_level_commander import HighLevelCommander
from cflib.crazyflie.supervisor import Supervisor
from procedure_room import ProcedureRoom
from procedure_vehicles import NAMES, SCENARIO
from rcl_interfaces.msg import ParameterType, ParameterValue
from rcl_interfaces.srv import GetParameters

from q2q_control.crazyswarm.message_conversion import NamedPose
from q2q_control.ros import procedure_services, server_vehicles
from q2q_control.ros.crazyswarm_bridge import Crazyswarm
from q2q_control.ros.crazyswarm_types import find_pose_types
from q2q_model.ros.topics.messages import header_at
from q2q_model.signals.values import MocapFrame
from q2q_model.trajectory.polynomials import SwarmPlan
from q2q_sim.ros.absent_packages import interface_packages
from q2q_sim.scenarios import library


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
    backend: str = "cpp"
    """Which of Crazyswarm2's servers it is."""
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

    def take_off(self, height: float, duration: float) -> None:
        """Let all vehicles take off to a height [m] in a duration [s], as another client asks it."""
        for one in self._high:
            one.takeoff(height, duration)

    def full_state(self, row: int, message: object) -> None:
        """Send a vehicle the setpoint of a message."""
        where, how, acc = message.pose.position, message.twist.linear, message.acc
        turn = message.pose.orientation
        self.room.log.append("cmd_full_state")
        self._commanders[row].send_full_state_setpoint(
            (where.x, where.y, where.z), (how.x, how.y, how.z), (acc.x, acc.y, acc.z),
            (turn.x, turn.y, turn.z, turn.w), 0.0, 0.0, message.twist.angular.z,
        )  # fmt: skip

    def legacy(self, row: int, message: object) -> None:
        """Send a vehicle the RPYT setpoint of a message, as crazyflie_cpp or the cflib server does."""
        roll, nose_up, yaw_rate = message.linear.y, -message.linear.x, message.angular.z
        pitch = nose_up if self.backend == "cflib" else -nose_up  # cflib's send_setpoint negates it
        thrust = int(min(max(message.linear.z, 0.0), 60000.0))
        self.room.log.append("cmd_vel_legacy" if thrust else "thrust 0")
        self._commanders[row].send_setpoint(roll, pitch, yaw_rate, thrust)

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
    server = Server(room, backend=str(given.get("backend", "cpp")))
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
        room.node.forward |= {
            f"{name}/cmd_full_state": partial(server.full_state, row),
            f"{name}/cmd_vel_legacy": partial(server.legacy, row),
        }
    types = find_pose_types(version)

    def see(frame: MocapFrame, stamp_ns: int) -> None:
        rows = zip(frame.names, frame.pos.tolist(), frame.quat.tolist(), strict=True)
        poses = [NamedPose(name, tuple(pos), tuple(quat)) for name, pos, quat in rows]
        room.node.takers["/poses"](types.write(header_at(stamp_ns), poses))
        if room.room.tick % 50 == 0:
            server.publish()

    room.mocap = see
    return room, server


def said_in_order(room: ProcedureRoom) -> list[str]:
    """Return, and forget, what servers were asked and sent; repetitions count once."""
    order = [one for k, one in enumerate(room.log) if k == 0 or room.log[k - 1] != one]
    room.log.clear()
    return order
