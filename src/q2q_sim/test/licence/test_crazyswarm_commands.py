"""Commands of Crazyswarm2: packets decode to the numbers given."""

import math
import struct
from pathlib import Path

import numpy as np
import pytest

from cflib_fleet import CflibFleet
from q2q_sim.crtp.packets.packet import Packet, Port, datagram_of, packet_of
from q2q_sim.firmware.commander.setpoint import Mode, Setpoint
from q2q_sim.firmware.controllers.columns import MOTOR
from q2q_sim.firmware.parameters.uploads import Uploaded
from q2q_sim.licence.client_commands.client_command import CommandKind
from q2q_sim.licence.client_commands.packet_command import client_command
from q2q_sim.licence.client_commands.setpoint_text import setpoint_text
from q2q_sim.licence.crazyflie_py import server_packets
from q2q_sim.licence.crazyflie_py.ellipsoids import (
    check_ellipsoid_collisions,
    poisson_disk_sample,
)
from q2q_sim.licence.crazyflie_py.uav_trajectory import (
    GRAVITY,
    Polynomial4D,
    UavTrajectory,
)
from q2q_sim.licence.room.licence_room import (
    LicenceParams,
    LicenceRoom,
    OpenLink,
    Sender,
    may_run_motors,
)
from q2q_sim.licence.room.trials import LicenceTrial

MM = 1e-3
"""Resolution of full states [m], [m/s], [m/s^2], [rad/s]."""
QUAT_PART = 7.1e-4
"""Largest error of a part of a quaternion in 32 bits (geometry.quaternion32)."""


def requested(packet: Packet) -> Setpoint:
    """Return the setpoint that a firmware makes of a packet."""
    crazyflies = CflibFleet(np.zeros((1, 4)))
    crazyflies.fleet.vehicles[0].handle(datagram_of(packet))
    assert crazyflies.fleet.vehicles[0].refusals.count == 0
    return crazyflies.firmware().requested


def test_a_full_state_reaches_the_firmware_with_the_numbers_given():
    pos, vel, acc, omega = (1.234, -0.567, 0.891), (0.5, -1.5, 0.25), (2.5, -3.25, 9.0), (0.1, -0.2, 1.5)
    one = requested(server_packets.full_state(pos, vel, acc, 0.6, omega))
    assert one.pos == pytest.approx(pos, abs=MM)
    assert one.vel == pytest.approx(vel, abs=MM)
    assert one.acc == pytest.approx(acc, abs=MM)
    assert np.radians(one.rate_deg) == pytest.approx(omega, abs=MM)
    assert (one.x, one.y, one.z, one.quat) == (Mode.ABS,) * 4
    about_x = (math.sin(0.3), 0.0, 0.0, math.cos(0.3))  # rowan.from_euler(0, 0, 0.6)
    assert one.attitude_quat == pytest.approx(about_x, abs=QUAT_PART)


def test_positions_and_hover_setpoints_reach_the_firmware_with_their_units_and_signs():
    one = requested(server_packets.position((0.1, -0.2, 0.3), 45.0))
    assert one.pos == pytest.approx((0.1, -0.2, 0.3))
    assert one.attitude_deg[2] == pytest.approx(45.0)
    hover = requested(server_packets.hover(0.1, -0.2, 0.5, 0.7))
    assert hover.vel == pytest.approx((0.1, -0.2, 0.0))
    assert hover.pos[2] == pytest.approx(0.7)
    assert hover.rate_deg[2] == pytest.approx(math.degrees(0.5))  # left, as the caller means
    assert hover.velocity_body


def wave() -> UavTrajectory:
    """Return a trajectory of two smooth pieces in all axes."""
    one = UavTrajectory()
    generator = np.random.default_rng(1)
    one.polynomials = [
        Polynomial4D(duration, *(generator.normal(size=8) / 2.0 ** np.arange(8) for _ in range(4)))
        for duration in (1.0, 1.5)
    ]
    one.duration = 2.5
    return one


def test_an_uploaded_trajectory_is_flown_as_it_is_evaluated():
    crazyflies = CflibFleet(np.zeros((1, 4)))
    crazyflies.fly(1.0)
    trajectory = wave()
    pieces = [
        (one.duration, np.stack([np.asarray(axis.p) for axis in (one.px, one.py, one.pz, one.pyaw)]))
        for one in trajectory.polynomials
    ]
    vehicle, begin = crazyflies.fleet.vehicles[0], crazyflies.firmware().seconds
    for packet in server_packets.upload(3, 2, pieces):
        vehicle.handle(datagram_of(packet))
    (answer,) = vehicle.handle(
        datagram_of(server_packets.start(3, 1.0, backwards=False, relative=False, mask=0))
    )
    assert packet_of(answer).data[3] == 0
    for t in (0.0, 0.4, 0.99, 1.3, 2.4):
        goal, state = crazyflies.firmware().planner.goal(begin + t), trajectory.eval(t)
        assert goal is not None
        single = 1e-4  # coefficients have 24 bits
        assert goal.pos == pytest.approx(state.pos, abs=single)
        assert goal.vel == pytest.approx(state.vel, abs=single)
        assert goal.acc == pytest.approx(state.acc, abs=10.0 * single)


def test_the_states_of_a_trajectory_are_derivatives_of_each_other():
    trajectory, step = wave(), 1e-5
    for t in (0.3, 0.8, 1.7):
        before, now, after = (trajectory.eval(t + k * step) for k in (-1, 0, 1))
        assert now.vel == pytest.approx((after.pos - before.pos) / (2.0 * step), rel=1e-6, abs=1e-6)
        assert now.acc == pytest.approx((after.vel - before.vel) / (2.0 * step), rel=1e-6, abs=1e-6)


def test_body_rates_have_the_closed_form_of_a_small_jerk():
    jerk, yaw_rate = 0.6, 0.4
    along_x = np.array([0.0, 0.0, 0.0, jerk / 6.0, 0.0, 0.0, 0.0, 0.0])
    turning = np.array([0.0, yaw_rate, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    omega = Polynomial4D(1.0, along_x, np.zeros(8), np.zeros(8), turning).eval(0.0).omega
    assert omega == pytest.approx([0.0, jerk / GRAVITY, yaw_rate])  # nose down for a jerk forward
    omega = Polynomial4D(1.0, np.zeros(8), along_x, np.zeros(8), turning).eval(0.0).omega
    assert omega == pytest.approx([-jerk / GRAVITY, 0.0, yaw_rate])  # roll left for one to the left


def test_a_file_is_read_row_by_row(tmp_path: Path):
    rows = np.arange(66.0).reshape(2, 33)
    file = tmp_path / "path.csv"
    np.savetxt(file, rows, delimiter=",", header="duration,x^0")
    one = UavTrajectory()
    assert one.polynomials is None
    assert one.duration is None
    for ask in (one.n_pieces, lambda: one.eval(0.0)):
        with pytest.raises(TypeError, match="a trajectory without polynomials: read a file by loadcsv"):
            ask()
    one.loadcsv(file)
    assert (one.n_pieces(), one.duration) == (2, 33.0)
    assert list(one.polynomials[1].py.p) == list(range(42, 50))
    with pytest.raises(ValueError, match=r"must be in \[0, 33\.0\] s"):
        one.eval(33.1)


def test_ellipsoids_touch_at_two_radii_and_sampled_points_keep_their_distance():
    radii = np.array([0.12, 0.12, 0.3])
    above = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.5], [0.5, 0.0, 0.0]])
    assert check_ellipsoid_collisions(above, radii).tolist() == [True, True, False]
    points = poisson_disk_sample(6, 2, 0.4)
    apart = np.linalg.norm(points[:, None] - points[None], axis=-1)
    assert apart[np.triu_indices(6, 1)].min() >= 0.4


def test_a_command_for_another_group_asks_nothing_of_a_vehicle():
    crazyflies = CflibFleet(np.zeros((1, 4)))
    crazyflies.fly(1.0)
    for mask, kind in ((0, CommandKind.PLAN), (1, CommandKind.PLAN), (2, CommandKind.OTHER)):
        crazyflies.firmware().parameters.set("hlCommander.groupmask", 1)
        packet = server_packets.vertical(server_packets.TAKE_OFF, 0.5, 1.0, mask)
        asked = client_command(packet, [], crazyflies.firmware())
        assert asked is not None
        assert asked.kind == kind
    assert asked.words == "takeoff for another group"


def test_old_take_offs_are_reported_with_their_height_which_may_leave_the_room():
    crazyflies = CflibFleet(np.zeros((1, 4)))
    crazyflies.fly(1.0)
    asked = client_command(
        server_packets.vertical(server_packets.TAKE_OFF, 60.0, 2.0, 0), [], crazyflies.firmware()
    )
    assert asked is not None
    assert asked.pos is not None
    assert (asked.words, asked.pos[2], asked.yaw_rad) == ("takeoff to 60.00 m in 2.0 s", 60.0, 0.0)


def test_the_start_of_a_trajectory_asks_for_one_that_is_defined():
    crazyflies = CflibFleet(np.zeros((1, 4)))
    crazyflies.fly(1.0)
    start = Packet(Port.HIGH_LEVEL, 0, struct.pack("<BBBBBf", 5, 0, 0, 0, 2, 1.0))
    for defined, impossible in ((1, "trajectory 2, which is not defined"), (2, "")):
        crazyflies.firmware().uploads.defined[defined] = Uploaded(1, 0, 0, 1)
        asked = client_command(start, [], crazyflies.firmware())
        assert asked is not None
        assert (asked.words, asked.impossible) == ("start_trajectory", impossible)


def test_a_position_is_impossible_with_the_complementary_estimator_and_an_attitude_is_not():
    crazyflies = CflibFleet(np.zeros((1, 4)))
    crazyflies.fly(1.0)
    climb = server_packets.vertical(server_packets.TAKE_OFF, 0.5, 2.0, 0)
    there = server_packets.position((0.2, 0.0, 0.5), 0.0)
    level = Packet(Port.SETPOINT, 0, struct.pack("<fffH", 1.0, 0.0, 0.0, 40000))
    message = "a position that its complementary estimator does not know"
    for estimator, impossible in ((2, ["", "", ""]), (1, [message, message, ""])):
        crazyflies.firmware().parameters.set("stabilizer.estimator", estimator)
        crazyflies.firmware().thrust_locked = False
        found = []
        for packet in (climb, there, level):
            crazyflies.fleet.vehicles[0].handle(datagram_of(packet))
            asked = client_command(packet, [], crazyflies.firmware())
            assert asked is not None
            found.append(asked.impossible)
        assert found == impossible


@pytest.mark.parametrize("port", [(Port.SUPERVISOR, 1), (Port.LOCALIZATION, 1)])
def test_the_emergency_stop_and_its_watchdog_have_two_ports(port: tuple[Port, int]) -> None:
    crazyflies = CflibFleet(np.zeros((1, 4)))
    kinds = []
    for first in (3, 4, 5):
        asked = client_command(Packet(*port, bytes([first])), [], crazyflies.firmware())
        kinds.append(asked.kind if asked is not None else None)
    assert kinds == [CommandKind.EMERGENCY, CommandKind.WATCHDOG, None]


def test_a_thrust_that_the_firmware_takes_for_none_is_reported_and_no_thrust_is_not():
    crazyflies = CflibFleet(np.zeros((1, 4)))
    crazyflies.fly(1.0)
    for thrust, refused in (
        (0, ""),
        (36, "the firmware treats a thrust below 1000 of 65535 as none"),
        (36000, ""),
    ):
        packet = Packet(Port.SETPOINT, 0, struct.pack("<fffH", 0.0, 0.0, 0.0, thrust))
        crazyflies.fleet.vehicles[0].handle(datagram_of(packet))
        asked = client_command(packet, [], crazyflies.firmware())
        assert asked is not None
        assert (asked.kind, asked.refused) == (CommandKind.SETPOINT if thrust else CommandKind.OFF, refused)


def test_a_setpoint_that_is_no_number_is_reported_as_impossible_and_the_one_before_is_not_repeated():
    room = LicenceRoom(LicenceParams(((0.0, 0.0, 0.0),)), LicenceTrial())
    for x in (0.25, math.nan):
        room.deliver(
            OpenLink(0), datagram_of(server_packets.position((x, 0.0, 0.5), 0.0)), x, Sender(7, closing=False)
        )
    assert [one.asked.words for one in room.commands] == ["setpoint x 0.25 m, y 0.00 m, z 0.50 m", "setpoint"]
    assert [one.asked.impossible for one in room.commands] == ["", "a number that is not finite"]


def test_motors_count_as_running_while_a_controller_of_the_height_may_run_them():
    crazyflies = CflibFleet(np.array([[0.0, 0.0, 1.0, 0.0]]))
    crazyflies.fly(2.0, crazyflies.hold(Setpoint(x=Mode.ABS, y=Mode.ABS, z=Mode.ABS, pos=(0.0, 0.0, 1.0))))
    one = crazyflies.firmware()
    one.rows.memory[MOTOR : MOTOR + 4] = 0.0
    assert may_run_motors(one)
    one.supervisor.stop()
    crazyflies.fly(0.1)
    one.rows.memory[MOTOR : MOTOR + 4] = 0.0
    assert not may_run_motors(one)


def test_the_words_of_a_setpoint_name_a_yaw_and_a_yaw_rate_that_are_not_zero():
    at_rest = ((0.1, 0.0, 0.5), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    right = Packet(Port.SETPOINT, 0, struct.pack("<fffH", 1.0, 0.0, 450.0, 40000))
    for packet, words in (
        (server_packets.hover(0.1, 0.0, 7.0, 0.7), "vx 0.10 m/s, vy 0.00 m/s, z 0.70 m, yaw rate 401 deg/s"),
        (server_packets.hover(0.0, 0.0, 0.0, 0.7), "vx 0.00 m/s, vy 0.00 m/s, z 0.70 m"),
        (server_packets.position((0.1, -0.2, 0.3), 45.0), "x 0.10 m, y -0.20 m, z 0.30 m, yaw 45 deg"),
        (
            server_packets.full_state(*at_rest, 0.0, (1.0, 0.0, -7.0)),
            "x 0.10 m, y 0.00 m, z 0.50 m, yaw rate -401 deg/s",
        ),
        (right, "thrust 0, roll 1.0 and pitch 0.0 deg, yaw rate -450 deg/s"),  # the thrust is locked
    ):
        assert setpoint_text(requested(packet)) == f"setpoint {words}"
