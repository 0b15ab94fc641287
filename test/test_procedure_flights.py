"""Whole flights by the procedure, through the nodes `radio` and `crazyswarm`, in simulated time.

Each of four accidents that hurt people is played: nothing moves, or the refusal names why.
"""

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
from q2q_control.radio.cflib_link import OnboardPose
from q2q_control.radio.firmware_params import difference
from q2q_control.radio.link import CflibSender, LinkHealth
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
from q2q_planner.playing.plan_player import Played
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
class _Link(CflibSender):
    """cflib's encoders on a simulated vehicle, and the vehicle's own word on its health."""

    firmware: Firmware
    params: Mapping[str, float]
    """What is set once connected."""
    reported: dict[str, object] = field(default_factory=dict)
    """What is told in place of the truth."""

    @property
    def pose(self) -> OnboardPose:
        x, y, z = self.firmware.pos.tolist()
        return OnboardPose((x, y, z), (0.0, 0.0, 0.0, 1.0))

    def health(self) -> LinkHealth:
        bits = self.firmware.info
        truth = LinkHealth(
            connected=True,
            volt=self.firmware.battery.volt,
            armed=bits & READY == READY,
            locked=bool(bits & Info.LOCKED),
            onboard=self.pose.pos,
            wrong=difference(
                self.params, {name: float(self.firmware.parameters[name]) for name in self.params}
            ),
            own_hover=OwnHover(*(float(self.firmware.parameters[name]) for name in OWN_PARAMETERS)),
        )
        return replace(truth, **self.reported)

    def keep_open(self) -> None:
        """Stay open."""

    def log_lines(self) -> list[str]:
        return []

    def close(self) -> None:
        """End."""


@dataclass
class _Flown:
    """A room, and the links by which `radio` flies its vehicles."""

    room: ProcedureRoom
    links: dict[str, _Link] = field(default_factory=dict)


def by_radio(monkeypatch: pytest.MonkeyPatch, plan: SwarmPlan | None = None, **given: object) -> _Flown:
    """Return a room whose vehicles `radio` flies over cflib's encoders."""
    room = ProcedureRoom(library.load(SCENARIO), monkeypatch, plan, auto_arming=False)
    flown = _Flown(room)

    def link(name: str, _: str, params: Mapping[str, float], __: str) -> _Link:
        row = NAMES.index(name)
        wire, firmware = room.wire(row), room.fleet.vehicles[row].firmware
        for parameter, value in params.items():
            firmware.parameters.set(parameter, value)
        parts = Commander(wire), HighLevelCommander(wire), Localization(wire), Supervisor(wire)
        return flown.links.setdefault(name, _Link(*parts, firmware, params))

    monkeypatch.setattr(radio_vehicles, "CflibLink", link)
    monkeypatch.setattr(radio_topics.RadioTopics, "other_radios", lambda _: "")
    monkeypatch.setattr(radio_topics.RadioTopics, "publish", lambda *_: None)
    room.clock(radio_wiring, procedure_services)
    uris = tuple(f"udp://127.0.0.1:{19850 + k}" for k in range(2))
    vehicle = room.scenario.vehicle.name
    room.start("radio", {"vehicles": NAMES, "uris": uris, "vehicle": vehicle, **given}, RadioNode, {})
    return flown


@dataclass
class _Server:
    """Crazyswarm2's server, as far as the procedure goes: cflib's encoders behind its services and topics."""

    room: ProcedureRoom
    ignore_signals: set[str] = field(default_factory=set)
    """Services that answer and do nothing."""
    tells: set[str] = field(default_factory=lambda: {"status", "onboard", "parameters"})
    """What it was set up to tell."""
    offset: float = 0.0
    """Of the estimates from the truth [m]."""
    held: dict[str, float] = field(default_factory=dict)
    """Parameters that it tells in place of the vehicles'."""

    def __post_init__(self) -> None:
        wires = [self.room.wire(row) for row in range(2)]
        self._commanders = [Commander(wire) for wire in wires]
        self._high = [HighLevelCommander(wire) for wire in wires]
        self._supervisors = [Supervisor(wire) for wire in wires]
        for vehicle in self.room.fleet.vehicles:
            vehicle.firmware.parameters.set("stabilizer.controller", 2.0)

    def services(self) -> dict[str, Callable[[object], object]]:
        acts: dict[str, Callable[[int, object], None]] = {
            "takeoff": lambda k, one: self._high[k].takeoff(one.height, one.duration.sec),
            "land": lambda k, one: self._high[k].land(one.height, one.duration.sec),
            "arm": lambda k, one: self._supervisors[k].send_arming_request(do_arm=one.arm),
            "notify_setpoints_stop": lambda k, _: self._commanders[k].send_notify_setpoint_stop(),
            "emergency": lambda k, _: self._supervisors[k].send_emergency_stop(),
        }
        served = {f"all/{name}": self._serve(name, act) for name, act in acts.items()}
        return served | {"crazyflie_server/get_parameters": self._parameters}

    def _parameters(self, request: GetParameters.Request) -> GetParameters.Response:
        """Answer as rclcpp does: nothing at all where one of the parameters has no value."""
        if "parameters" not in self.tells:
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
            x, y, z = firmware.pos.tolist()
            onboard = kinds.LogDataGeneric(values=[x, y + self.offset, z])
            for topic, message in (("status", status), ("onboard", onboard)):
                if topic in self.tells:
                    takers[f"{vehicle.name}/{topic}"](message)

    def _serve(self, name: str, act: Callable[[int, object], None]) -> Callable[[object], object]:
        def serve(request: object) -> object:
            self.room.log.append(name)
            for row in range(2):
                if name not in self.ignore_signals:
                    act(row, request)
            return object()

        return serve


def by_bridge(
    monkeypatch: pytest.MonkeyPatch, plan: SwarmPlan | None = None, *, version: int = 1, **given: object
) -> tuple[ProcedureRoom, _Server]:
    """Return a room whose vehicles Crazyswarm2's server flies, and the server."""
    for name, module in interface_packages().items():
        monkeypatch.setitem(sys.modules, name, module)
    room = ProcedureRoom(library.load(SCENARIO), monkeypatch, plan, auto_arming=False)
    server = _Server(room)
    room.clock(server_vehicles, procedure_services)
    asked = {
        "vehicles": NAMES,
        "poses_version": version,
        "poses_out": "/poses_filtered",
        "vehicle": room.scenario.vehicle.name,
        **given,
    }
    room.start("crazyswarm", asked, Crazyswarm, server.services())
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


def test_table6_by_radio_from_the_ground_to_the_ground(monkeypatch: pytest.MonkeyPatch) -> None:
    room = by_radio(monkeypatch).room
    room.wait(1.5)
    fly_plan(room, *TABLE6_ENDS)
    assert room.height_error(50.0).max() < 0.08  # the paper's soft loop (K_p 0.81), aware: 27 mm direct
    land(room)


def test_a_plan_is_flown_by_radio_three_times_in_a_row(monkeypatch: pytest.MonkeyPatch) -> None:
    room = by_radio(monkeypatch, SHORT).room
    room.wait(1.5)
    for _ in range(3):
        fly_plan(room, *SHORT_ENDS)
        assert room.height_error(3.0).max() < 0.08
        land(room)


def test_full_states_by_radio_from_the_ground_to_the_ground(monkeypatch: pytest.MonkeyPatch) -> None:
    room = by_radio(monkeypatch, SHORT, mode="setpoint").room
    room.wait(1.5)
    assert room.call(Call.TAKE_OFF).granted, room.node.lines[-5:]
    np.testing.assert_allclose(room.height[-1], 0.5, atol=0.15)
    assert room.call(Call.FLY).granted
    room.wait(3.0)
    assert room.height_error(3.0).max() < 0.005  # as by the bridge: the same packets
    land(room)


def test_a_parameter_that_a_vehicle_does_not_hold_refuses_the_take_off(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    flown = by_radio(monkeypatch, SHORT, mode="setpoint")
    flown.room.wait(1.5)
    flown.links["cf2"].firmware.parameters.set("stabilizer.controller", 1)
    refusal = flown.room.call(Call.TAKE_OFF)
    assert "cf2: its stabilizer.controller is 1, expected 2" in refusal.reason
    flown.room.wait(1.0)
    assert flown.room.highest() < 0.01


def test_calls_at_the_wrong_time_move_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    room = by_radio(monkeypatch, SHORT).room
    room.wait(1.5)
    refused(room, Step.CHECKED)
    room.wait(1.0)
    assert room.highest() < 0.01
    assert room.call(Call.TAKE_OFF).granted
    hovering = room.fleet.vehicles[0].firmware.pos.copy()
    refused(room, Step.HOVER)
    room.wait(1.0)
    np.testing.assert_allclose(room.fleet.vehicles[0].firmware.pos, hovering, atol=0.02)


def test_a_flight_that_is_held_is_flown_again_from_there(monkeypatch: pytest.MonkeyPatch) -> None:
    room = by_radio(monkeypatch, SHORT).room
    room.wait(1.5)
    for call in (Call.TAKE_OFF, Call.FLY, Call.HOLD, Call.FLY, Call.LAND):
        assert room.call(call).granted, room.node.lines[-5:]


def test_a_start_in_the_middle_of_a_plan_is_refused_with_the_distance(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The plan runs since 25 s: vehicles would jump from the ground to 1.5 and 2 m, one above the other."""
    room = by_radio(monkeypatch).room
    room.player.played = Played(room.plan, -25.0)
    room.wait(1.5)
    refusal = room.call(Call.START)
    assert not refusal.granted
    assert "cf1 is 1.50 m from its setpoint: 0.30 m is the most" in refusal.reason
    room.wait(2.0)
    assert room.highest() < 0.01


def test_a_thrust_scale_of_another_vehicle_refuses_the_take_off(monkeypatch: pytest.MonkeyPatch) -> None:
    """A stick for the wrong vehicle asks for less than hovers: the vehicle's own parameters tell."""
    flown = by_radio(monkeypatch)
    flown.room.wait(1.5)
    flown.links["cf2"].reported["own_hover"] = OwnHover(mass=0.034, mass_thrust=132000.0)
    refusal = flown.room.call(Call.TAKE_OFF)
    assert "cf2 would be sent 68 % of the thrust at which it hovers: within 15 %" in refusal.reason
    flown.room.wait(2.0)
    assert flown.room.highest() < 0.01


def test_a_plan_that_plays_by_itself_is_not_taken_over(monkeypatch: pytest.MonkeyPatch) -> None:
    room = by_radio(monkeypatch).room
    room.wait(1.5)
    assert room.call(Call.TAKE_OFF).granted
    room.player.played = Played(room.plan, -20.0)  # started late, by whoever
    room.tick()
    refusal = room.call(Call.FLY)
    assert not refusal.granted
    np.testing.assert_allclose(room.height[-1], 0.5, atol=0.15)


def test_a_plan_that_jumps_in_flight_is_not_followed(monkeypatch: pytest.MonkeyPatch) -> None:
    """A trajectory that is started anew plays its plan from the first point."""
    room = by_radio(monkeypatch).room
    room.wait(1.5)
    assert room.call(Call.TAKE_OFF).granted
    assert room.call(Call.FLY).granted
    room.wait(20.0)
    room.player.played = Played(room.plan, room.player.played.start + 20.0)
    room.wait(12.0)
    assert room.height[-1].max() < 0.02
    assert any("a setpoint jumped by" in line for line in room.node.lines)


def test_a_dry_run_by_radio_moves_nothing_and_says_what_would_be_sent(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    room = by_radio(monkeypatch, dry_run=True).room
    room.wait(1.5)
    reply = room.call(Call.TAKE_OFF)
    assert "arm, then take off to 0.50 m in 2.0 s" in reply.reason
    room.wait(3.0)
    assert room.highest() < 0.01


def test_nothing_climbs_before_take_off_is_called_and_nothing_is_streamed_before_fly(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    room, _ = by_bridge(monkeypatch, SHORT)
    room.wait(5.0)
    assert room.highest() < 0.01
    assert room.log == []
    assert room.call(Call.TAKE_OFF).granted
    assert room.log == ["trajectory/wait", "arm", "takeoff"]
    np.testing.assert_allclose(room.height[-1], 0.5, atol=0.15)


SERVERS_ORDER = [
    "trajectory/wait", "arm", "takeoff",
    "trajectory/glide", "cmd_full_state", "trajectory/start", "cmd_full_state",
    "trajectory/glide", "cmd_full_state", "notify_setpoints_stop", "land", "arm",
]  # fmt: skip


def said_in_order(room: ProcedureRoom) -> list[str]:
    """Return, and forget, what servers were asked and sent; repetitions count once."""
    order = [one for k, one in enumerate(room.log) if k == 0 or room.log[k - 1] != one]
    room.log.clear()
    return order


def test_table6_by_the_bridge_flies_lands_and_disarms_in_the_servers_order(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    room, _ = by_bridge(monkeypatch)
    room.wait(1.5)
    fly_plan(room, *TABLE6_ENDS)
    assert room.height_error(50.0).max() < 0.005
    land(room)
    assert said_in_order(room) == SERVERS_ORDER


def test_a_plan_is_flown_by_the_bridge_three_times_in_a_row(monkeypatch: pytest.MonkeyPatch) -> None:
    room, _ = by_bridge(monkeypatch, SHORT)
    room.wait(1.5)
    for _ in range(3):
        fly_plan(room, *SHORT_ENDS)
        assert room.height_error(3.0).max() < 0.005
        land(room)
        assert said_in_order(room) == SERVERS_ORDER


def test_the_bridge_flies_with_poses_of_the_second_version(monkeypatch: pytest.MonkeyPatch) -> None:
    room, _ = by_bridge(monkeypatch, SHORT, version=2)
    room.wait(1.5)
    for call in (Call.TAKE_OFF, Call.FLY):
        assert room.call(call).granted, room.node.lines[-5:]
    room.wait(4.0)
    land(room)
    assert said_in_order(room) == SERVERS_ORDER


def test_a_landing_that_does_not_happen_is_not_a_success(monkeypatch: pytest.MonkeyPatch) -> None:
    """A server that is deaf to `land`: it answers, and the vehicles stay up."""
    room, server = by_bridge(monkeypatch, SHORT)
    room.wait(1.5)
    assert room.call(Call.TAKE_OFF).granted
    server.ignore_signals.add("land")
    reply = room.call(Call.LAND)
    assert not reply.granted
    assert "not on the ground: cf1 is at 0.5" in reply.reason
    server.ignore_signals.clear()
    assert room.call(Call.LAND).granted


def test_a_battery_that_the_server_does_not_log_refuses_the_take_off(monkeypatch: pytest.MonkeyPatch) -> None:
    room, server = by_bridge(monkeypatch)
    server.tells.remove("status")
    room.wait(1.5)
    assert "cf1 does not report its battery" in room.call(Call.TAKE_OFF).reason


REFUSED_BY_WHAT_THE_SERVER_TELLS = [
    ({"offset": 0.3}, "cf1 estimates itself 0.30 m from its measured position: 0.10 m is the most"),
    (
        {"held": {"ctrlMel.mass": 0.034, "ctrlMel.massThrust": 132000.0}},
        "cf1 would be sent 68 % of the thrust",
    ),
    ({"held": {"stabilizer.controller": 1.0}}, "cf1: its stabilizer.controller is 1, expected 2"),
]


@pytest.mark.parametrize(("reported", "why"), REFUSED_BY_WHAT_THE_SERVER_TELLS)
def test_the_bridge_refuses_the_take_off_by_what_the_server_tells(
    monkeypatch: pytest.MonkeyPatch, reported: dict[str, object], why: str
) -> None:
    room, server = by_bridge(monkeypatch, SHORT)
    for name, value in reported.items():
        setattr(server, name, value)
    room.wait(1.5)
    assert why in room.call(Call.TAKE_OFF).reason
    assert not {"arm", "takeoff"} & set(room.log)


def test_an_estimate_that_is_no_longer_told_refuses_the_take_off(monkeypatch: pytest.MonkeyPatch) -> None:
    room, server = by_bridge(monkeypatch, SHORT)
    room.wait(1.5)
    server.tells.remove("onboard")
    room.wait(3.1)
    assert "cf1 stopped sending its own estimate x, y, z" in room.call(Call.TAKE_OFF).reason


def test_what_the_server_does_not_tell_is_said_not_to_be_checked(monkeypatch: pytest.MonkeyPatch) -> None:
    room, server = by_bridge(monkeypatch, SHORT)
    server.tells = {"status"}
    room.wait(1.5)
    words = "not checked: parameters of cf1, cf2; own estimate of cf1, cf2; thrust scale of cf1, cf2"
    assert room.node.lines[-1] == f"step checked: {words}"
    values = {one.key: one.value for one in room.node.published["~/status"][-1].values}
    assert values == {"take_off_refusal": "", "unchecked": words}
    assert room.call(Call.TAKE_OFF).granted
    assert f"step arming: {words}" in room.node.lines


def test_an_emergency_by_the_bridge_stops_the_motors(monkeypatch: pytest.MonkeyPatch) -> None:
    room, _ = by_bridge(monkeypatch, SHORT)
    room.wait(1.5)
    assert room.call(Call.TAKE_OFF).granted
    assert room.call(Call.EMERGENCY).granted
    room.wait(1.0)
    assert room.height[-1].max() < 0.02
    assert "the step is stopped" in room.call(Call.TAKE_OFF).reason
