"""Bridge to Crazyswarm2: poses in both versions, full states, RPYT setpoints, absent packages."""

import math
import sys
from dataclasses import dataclass, field, replace

import numpy as np
import pytest
import yaml
from fresh_checkout import ROOT

pytest.importorskip("q2q_msgs", reason="the workspace is not built")

from geometry_msgs.msg import Point

from q2q_control.crazyswarm.crazyswarm_params import CrazyswarmParams
from q2q_control.crazyswarm.message_conversion import NamedPose, legacy_twists, mocap_frame, poses_of
from q2q_control.radio.crazyflies_file import crazyflies_from_document
from q2q_control.radio.link.rpyt_scale import RpytScale
from q2q_control.ros.controller_wiring import LegacyTopics
from q2q_control.ros.crazyswarm_bridge import POSES_OUT, Crazyswarm
from q2q_control.ros.crazyswarm_types import find_pose_types
from q2q_control.ros.procedure_services import ProcedureServices
from q2q_model.node.warm_up import synthetic_signal
from q2q_model.ros.topics.messages import MESSAGES, header_at
from q2q_model.signals.cdr.cdr_reader import decode
from q2q_model.signals.cdr.cdr_writer import encode
from q2q_model.signals.values import (
    Interference,
    MocapFrame,
    SwarmCommand,
    SwarmSetpoint,
    SwarmState,
    TrackStatus,
)
from q2q_sim.ros.absent_packages import interface_packages
from q2q_sim.ros.stand_in import StandInNode

NAMES = ("cf1", "cf2")
NAN = (math.nan,) * 4
STAMP_NS = 1_230_000_000


@dataclass
class _Sent:
    """Keep what one publisher publishes, or what one client is asked."""

    messages: list[object] = field(default_factory=list)
    ready: bool = True

    def publish(self, message: object) -> None:
        self.messages.append(message)

    def get_subscription_count(self) -> int:
        return 1

    def service_is_ready(self) -> bool:
        return self.ready

    def call_async(self, request: object) -> "_Sent":
        self.messages.append(request)
        return self

    def add_done_callback(self, _: object) -> None:
        pass


class _Node(StandInNode):
    """Keep what a block publishes, serves, asks and says."""

    def __init__(self, **given: object) -> None:
        super().__init__("crazyswarm", {"vehicles": NAMES, **given})
        self.out: dict[str, _Sent] = {}
        self.lines: list[str] = []

    def create_publisher(self, kind: type, topic: str, qos: object) -> _Sent:
        super().create_publisher(kind, topic, qos)
        return self.out.setdefault(topic, _Sent())

    def create_client(self, kind: type, name: str) -> _Sent:
        super().create_client(kind, name)
        return self.out.setdefault(name, _Sent())

    def get_logger(self) -> "_Node":
        return self

    def warning(self, line: str) -> None:
        self.lines.append(line)

    def info(self, line: str) -> None:
        self.lines.append(line)

    def reader(self, kind: type) -> object:
        return next(receive for found, receive in self.readers if found is kind)

    def give(self, signal: object) -> None:
        self.reader(MESSAGES[type(signal)])(encode(signal, STAMP_NS))


@pytest.fixture(params=[False, True], ids=["named", "before 2021-12"])
def packages(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    for name, module in interface_packages(old_poses=request.param).items():
        monkeypatch.setitem(sys.modules, name, module)


def poses_message(poses: list[NamedPose]) -> object:
    return find_pose_types().write(header_at(STAMP_NS), poses)


@pytest.mark.usefixtures("packages")
def test_poses_become_a_frame_of_the_known_vehicles_in_both_versions() -> None:
    node = _Node()
    Crazyswarm(node)
    turn = (0.0, 0.0, math.sin(0.2), math.cos(0.2))
    poses = [NamedPose("wand", (9.0, 9.0, 9.0), turn), NamedPose("cf2", (1.0, 2.0, 3.0), turn),
             NamedPose("cf1", (4.0, 5.0, 6.0), NAN)]  # fmt: skip
    node.reader(find_pose_types().array)(poses_message(poses))
    (data,) = node.out["mocap"].messages
    frame = decode(data, MocapFrame)
    assert (frame.names, frame.t) == (("cf2", "cf1"), pytest.approx(1.23))
    np.testing.assert_array_equal(frame.pos, [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]])
    np.testing.assert_array_equal(frame.quat, [turn, NAN])


def test_half_an_orientation_is_none() -> None:
    frame = mocap_frame(0, [NamedPose("cf1", (0.0, 0.0, 0.0), (math.nan, 0.0, 0.0, 1.0))], NAMES)
    assert np.isnan(frame.quat).all()


@pytest.mark.usefixtures("packages")
def test_filtered_poses_go_out_where_measured_and_come_back_the_same() -> None:
    node = _Node(poses_out="/poses_filtered")
    Crazyswarm(node)
    state = replace(
        synthetic_signal(SwarmState, 0.0, NAMES),
        quat=np.tile([0.0, 0.6, 0.0, 0.8], (2, 1)),
        status=np.array([TrackStatus.TRACKED, TrackStatus.LOST], np.uint8),
    )
    node.give(state)
    (message,) = node.out["/poses_filtered"].messages
    types = find_pose_types()
    assert [types.read(one) for one in message.poses] == poses_of(state)
    assert [types.read(one).name for one in message.poses] == ["cf1"]


def test_a_pose_has_no_orientation_where_none_was_ever_measured() -> None:
    state = synthetic_signal(SwarmState, 0.0, NAMES)
    state.quat[:] = [[0.0, 0.0, 0.0, 1.0], [0.0, 0.0, 0.6, 0.8]]
    lone, body = poses_of(replace(state, status=np.zeros(2, np.uint8)))
    assert np.isnan(lone.quat).all()  # one server checks x, the other w
    assert body.quat == (0.0, 0.0, 0.6, 0.8)


def test_the_writer_of_poses_offers_the_deadline_that_the_servers_ask_for() -> None:
    assert POSES_OUT.deadline.nanoseconds == 10_000_000


@pytest.mark.usefixtures("packages")
def test_full_states_carry_setpoint_and_downwash_once_the_procedure_lets_them(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    node = _Node(poses_in="", aware=True)
    Crazyswarm(node)
    monkeypatch.setattr(ProcedureServices, "streams", True)
    setpoint, downwash = (synthetic_signal(kind, 0.0, NAMES) for kind in (SwarmSetpoint, Interference))
    setpoint = replace(
        setpoint, pos=np.arange(6.0).reshape(2, 3), acc=np.ones((2, 3)), yaw_rate=np.array([0.1, 0.2])
    )
    downwash = replace(downwash, acc=np.array([[0.0, 0.0, -0.5], [0.0, 0.0, 0.25]]))
    node.give(setpoint)
    assert node.out["cf1/cmd_full_state"].messages == []
    node.give(downwash)
    (message,) = node.out["cf2/cmd_full_state"].messages
    assert message.pose.position == Point(x=3.0, y=4.0, z=5.0)
    assert (message.acc.x, message.acc.y, message.acc.z) == (1.0, 1.0, 0.75)
    assert message.twist.angular.z == 0.2


def one_command() -> SwarmCommand:
    one = np.ones(2)
    return SwarmCommand(0.0, NAMES, 0.3 * one, 0.1 * one, 0.2 * one, 0.4 * one, np.zeros(2, np.uint8))


@pytest.mark.parametrize(("backend", "turned"), [("cpp", -1.0), ("cflib", 1.0)])
def test_both_servers_put_the_same_rpyt_setpoint_on_the_wire(backend: str, turned: float) -> None:
    """Cpp sends pitch = -linear.x as it is; the other gives -linear.x to cflib, which turns it again."""
    x, y, yaw_rate, pwm = legacy_twists(one_command(), RpytScale(0.48), backend)[0]
    wire_pitch = turned * x
    assert wire_pitch == pytest.approx(-math.degrees(0.2))  # legacy: nose up is positive
    assert (y, yaw_rate, pwm) == (
        pytest.approx(math.degrees(0.1)),
        pytest.approx(-math.degrees(0.4)),
        40959.0,  # 0.3 / 0.48 of 65535
    )


@pytest.mark.usefixtures("packages")
def test_rpyt_setpoints_are_sent_once_the_procedure_lets_them(monkeypatch: pytest.MonkeyPatch) -> None:
    node = _Node(mode="command", backend="cflib")
    Crazyswarm(node)
    node.give(one_command())
    assert node.out["cf1/cmd_vel_legacy"].messages == []
    monkeypatch.setattr(ProcedureServices, "streams", True)
    node.give(synthetic_signal(SwarmSetpoint, 0.0, NAMES))
    node.give(one_command())
    (twist,) = node.out["cf1/cmd_vel_legacy"].messages
    assert twist.linear.x == pytest.approx(-math.degrees(0.2))


@pytest.mark.usefixtures("packages")
def test_an_rpyt_setpoint_that_is_not_finite_is_not_sent(monkeypatch: pytest.MonkeyPatch) -> None:
    node = _Node(mode="command")
    Crazyswarm(node)
    monkeypatch.setattr(ProcedureServices, "streams", True)
    node.give(replace(one_command(), thrust=np.array([0.3, math.nan])))
    assert [len(node.out[f"{name}/cmd_vel_legacy"].messages) for name in NAMES] == [1, 0]


def test_a_controllers_own_rpyt_setpoints_are_those_that_the_default_server_takes() -> None:
    """Positive angular.z turned vehicles the other way: the server passes it on as the rate to the right."""
    node = _Node()
    LegacyTopics(node, RpytScale(0.48), 10.0, NAMES).publish(STAMP_NS, one_command())
    (twist,) = node.out["cf2/cmd_vel_legacy"].messages
    assert (twist.linear.x, twist.linear.y, twist.linear.z, twist.angular.z) == (
        pytest.approx(math.degrees(0.2)),
        pytest.approx(math.degrees(0.1)),
        40959.0,  # 0.3 / 0.48 of 65535
        pytest.approx(-math.degrees(0.4)),
    )
    server = tuple(legacy_twists(one_command(), RpytScale(0.48), CrazyswarmParams().backend)[1])
    assert (twist.linear.x, twist.linear.y, twist.angular.z, twist.linear.z) == server


def without(package: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Let a package be absent, also where Crazyswarm2 is installed."""
    for name in interface_packages():
        if name.startswith(package):
            monkeypatch.setitem(sys.modules, name, None)


def test_without_both_packages_the_node_names_them_and_does_not_start(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    without("", monkeypatch)
    node = _Node(mode="command")
    with pytest.raises(ValueError, match=r"no poses are passed on; .* no vehicle can fly") as refused:
        Crazyswarm(node)
    install = "is not installed (sudo apt install ros-jazzy-"
    assert str(refused.value) == (
        f"motion_capture_tracking_interfaces {install}motion-capture-tracking-interfaces): "
        f"no poses are passed on; crazyflie_interfaces {install}crazyflie-interfaces): no vehicle can fly"
    )


@pytest.mark.usefixtures("packages")
def test_without_the_vehicles_package_poses_pass_and_nothing_is_streamed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    without("crazyflie_interfaces", monkeypatch)
    node = _Node(mode="command")
    Crazyswarm(node)
    node.give(synthetic_signal(SwarmSetpoint, 0.0, NAMES))
    node.give(one_command())
    assert "mocap" in node.out
    assert "cf1/cmd_vel_legacy" not in node.out
    assert [line.partition(": ")[2] for line in node.lines] == ["no vehicle can fly"]


def test_the_tutorials_file_has_two_vehicles_to_fly_and_a_wand_to_leave_alone() -> None:
    page = ROOT / "docs/tutorials/real_vehicles_with_crazyswarm2.md"
    block = page.read_text().split("```yaml\n", 1)[1].split("```", 1)[0]
    found = crazyflies_from_document(yaml.safe_load(block))
    assert [(one.name, one.uri, one.start) for one in found] == [
        ("cf1", "radio://0/80/2M/E7E7E7E701", (0.0, 0.0, 0.0)),
        ("cf2", "radio://0/80/2M/E7E7E7E702", (-1.0, 0.0, 0.0)),
    ]


def test_poses_that_would_go_round_and_missing_vehicles_are_refused() -> None:
    with pytest.raises(ValueError, match="would loop forever"):
        CrazyswarmParams(poses_in="/poses", poses_out="/poses")
    with pytest.raises(ValueError, match="no vehicles"):
        Crazyswarm(_Node(vehicles=()))
