"""The high-level commander's polynomials: the firmware's own formula, exact ends, states and masks."""

import math
import struct

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import BPoly

from cflib_fleet import CflibFleet
from q2q_model.signals.values import Array
from q2q_sim.firmware.commander.compressed_pieces import compressed_pieces
from q2q_sim.firmware.commander.piecewise import Piecewise
from q2q_sim.firmware.commander.planner import Begin, Planner, PlannerResult, PlanState, Target, Vertical
from q2q_sim.firmware.commander.polynomial import Goal, Piece, goal_at, goal_at_rest, piece_between
from q2q_sim.firmware.commander.spiral import Spiral, spiral_piece

Numbers = tuple[float, ...]

YAW_32 = 2.4e-7
"""Last digit of a 32-bit float from 2 to 4: what wrapping leaves of a yaw [rad]."""
NUMBER = st.floats(-5.0, 5.0)
VECTOR = st.tuples(NUMBER, NUMBER, NUMBER).map(np.array)
GOAL = st.builds(
    lambda pos, vel, acc, yaw, rate: Goal(pos, vel, acc, yaw, np.array([0.0, 0.0, rate])),
    VECTOR, VECTOR, VECTOR, st.floats(-3.0, 3.0), NUMBER,
)  # fmt: skip


def firmware_formula(start: Numbers, end: Numbers, T: float) -> Array:
    """Return the coefficients as modules/src/pptraj.c (poly7_nojerk) states them, of value, slope, curve."""
    (x0, dx0, ddx0), (xf, dxf, ddxf) = start, end
    gap = x0 - xf
    return np.array(
        [
            x0,
            dx0,
            ddx0 / 2,
            0.0,
            -(5 * (14 * gap + 8 * T * dx0 + 6 * T * dxf + 2 * T**2 * ddx0 - T**2 * ddxf)) / (2 * T**4),
            (84 * gap + 45 * T * dx0 + 39 * T * dxf + 10 * T**2 * ddx0 - 7 * T**2 * ddxf) / T**5,
            -(140 * gap + 72 * T * dx0 + 68 * T * dxf + 15 * T**2 * ddx0 - 13 * T**2 * ddxf) / (2 * T**6),
            (2 * (10 * gap + 5 * T * dx0 + 5 * T * dxf + T**2 * ddx0 - T**2 * ddxf)) / T**7,
        ]
    )


@settings(deadline=None)
@given(GOAL, GOAL, st.floats(0.3, 10.0))
def test_pieces_are_those_of_the_firmwares_formula(start: Goal, end: Goal, duration: float) -> None:
    piece = piece_between(start, end, duration)
    for axis in range(3):
        ends = [(one.pos[axis], one.vel[axis], one.acc[axis]) for one in (start, end)]
        expected = firmware_formula(ends[0], ends[1], duration)
        scale = duration ** np.arange(8)  # compare the terms of x at the end, in metres
        np.testing.assert_allclose(piece.coefficients[axis] * scale, expected * scale, atol=1e-9 * 1e4)


@settings(deadline=None)
@given(GOAL, GOAL, st.floats(0.3, 10.0))
def test_pieces_meet_position_velocity_acceleration_and_yaw_at_both_ends(
    start: Goal, end: Goal, duration: float
) -> None:
    piece = piece_between(start, end, duration)
    for tau, demanded in ((0.0, start), (duration, end)):
        goal = goal_at(piece, tau)
        size = 1e-9 * (1.0 + 1e4 / duration**2)  # rounding of terms of up to 1e4 m
        np.testing.assert_allclose(goal.pos, demanded.pos, atol=size)
        np.testing.assert_allclose(goal.vel, demanded.vel, atol=size)
        np.testing.assert_allclose(goal.acc, demanded.acc, atol=size)
        assert goal.yaw == pytest.approx(demanded.yaw, abs=size)


def test_a_piece_of_no_duration_is_at_its_end_at_once() -> None:
    goal = goal_at(piece_between(goal_at_rest(np.zeros(3), 0.0), goal_at_rest(np.ones(3), 0.5), 0.0), 0.0)
    np.testing.assert_array_equal(goal.pos, np.ones(3))
    assert goal.yaw == 0.5


def test_body_rates_are_those_of_the_turning_thrust() -> None:
    piece = piece_between(goal_at_rest(np.zeros(3), 0.3), goal_at_rest(np.array([2.0, 1.0, 0.5]), 0.3), 2.0)
    dt, t = 1e-5, 0.6

    def up(tau: float) -> Array:
        thrust = goal_at(piece, tau).acc + np.array([0.0, 0.0, 9.81])
        return thrust / np.linalg.norm(thrust)

    turn = (up(t + dt) - up(t - dt)) / (
        2 * dt
    )  # = omega x z_body: x part -> rate about y, y part -> minus about x
    z = up(t)
    y = np.cross(z, [math.cos(0.3), math.sin(0.3), 0.0])
    y /= np.linalg.norm(y)
    x = np.cross(y, z)
    rates = goal_at(piece, t).ang_vel_body
    assert rates[1] == pytest.approx(float(turn @ x), rel=1e-5)  # finite differences of 1e-5 s
    assert rates[0] == pytest.approx(-float(turn @ y), rel=1e-5)


def test_states_follow_the_commands() -> None:
    planner = Planner()
    planner.set_state(np.array([1.0, 2.0, 0.0]), np.zeros(3), 0.5)
    assert planner.goal(0.0) is None
    assert planner.take_off(Vertical(1.0, 2.0, 0.0), 10.0) == PlannerResult.OK
    assert planner.take_off(Vertical(1.0, 2.0, 0.0), 10.0) == PlannerResult.WRONG_STATE
    top = planner.goal(13.0)
    np.testing.assert_allclose(top.pos, [1.0, 2.0, 1.0])
    assert planner.land(Vertical(0.0, 2.0), 13.0) == PlannerResult.OK
    assert planner.land(Vertical(0.0, 2.0), 13.0) == PlannerResult.WRONG_STATE
    assert planner.goal(14.0).pos[2] == pytest.approx(0.5)
    assert planner.goal(15.0) is None
    assert planner.state == PlanState.IDLE


def test_go_to_starts_from_the_goal_of_the_moment_and_turns_the_shorter_way() -> None:
    planner = Planner()
    planner.go_to(Target((2.0, 0.0, 1.0), 3.0, 2.0), 0.0)
    before = planner.goal(1.0)
    planner.go_to(Target((0.0, 0.0, 1.0), -3.0, 2.0), 1.0)
    after = planner.goal(1.0)
    np.testing.assert_allclose(after.pos, before.pos, atol=1e-12)
    np.testing.assert_allclose(after.vel, before.vel, atol=1e-12)
    np.testing.assert_allclose(after.acc, before.acc, atol=1e-12)
    assert after.yaw == pytest.approx(before.yaw)
    end = planner.goal(3.0)
    assert end.yaw % (2 * math.pi) == pytest.approx(-3.0 % (2 * math.pi))
    assert abs(end.yaw - after.yaw) <= math.pi


def test_relative_and_linear_go_to() -> None:
    planner = Planner()
    planner.set_state(np.array([1.0, 1.0, 1.0]), np.zeros(3), 0.2)
    planner.go_to(Target((1.0, 0.0, 0.0), 0.3, 2.0, relative=True, linear=True), 0.0)
    middle = planner.goal(0.7)
    np.testing.assert_allclose(middle.pos, [1.35, 1.0, 1.0])
    np.testing.assert_allclose(middle.vel, [0.5, 0.0, 0.0], atol=1e-12)
    assert planner.goal(2.0).yaw == pytest.approx(0.5)


def test_trajectories_are_shifted_turned_slowed_and_reversed() -> None:
    line = np.zeros((4, 8))
    line[0, 1], line[3, 0] = 1.0, 0.0  # x = t
    pieces = (Piece(1.0, line), Piece(2.0, line + np.eye(4, 8) * np.array([1.0, 0, 0, 0])[:, None]))
    forward = Piecewise(pieces, 5.0, timescale=2.0)
    np.testing.assert_allclose(forward.goal(7.0).pos[0], 1.0)
    np.testing.assert_allclose(forward.goal(8.0).vel[0], 0.5)  # half as fast
    np.testing.assert_allclose(forward.goal(99.0).pos[0], 3.0)
    np.testing.assert_allclose(forward.goal(99.0).vel, 0.0)
    back = Piecewise(pieces, 5.0, backwards=True)
    np.testing.assert_allclose(back.goal(5.0).pos[0], 3.0)
    np.testing.assert_allclose(back.goal(6.0).vel[0], -1.0)
    np.testing.assert_allclose(back.goal(99.0).pos[0], 0.0)
    planner = Planner()
    planner.set_state(np.array([1.0, 1.0, 1.0]), np.zeros(3), math.pi / 2)
    planner.follow(Piecewise(pieces, 0.0), Begin.HERE_TURNED)
    np.testing.assert_allclose(planner.goal(2.0).pos, [1.0, 3.0, 1.0], atol=2 * YAW_32)  # along the nose: y
    np.testing.assert_allclose(planner.goal(2.0).vel, [0.0, 1.0, 0.0], atol=YAW_32)


def test_a_turned_trajectory_is_shifted_by_its_unturned_start_and_backwards_not_turned() -> None:
    line = np.zeros((4, 8))
    line[:, 0], line[0, 1] = (2.0, 1.0, 0.5, 0.3), 1.0  # from (2, 1, 0.5) along x, yaw 0.3
    here = np.array([5.0, 6.0, 1.0])
    for backwards in (False, True):
        planner = Planner()
        planner.set_state(here, np.zeros(3), 0.3 + math.pi / 2)
        planner.follow(Piecewise((Piece(2.0, line),), 0.0, backwards=backwards), Begin.HERE_TURNED)
        start, later = planner.goal(0.0), planner.goal(1.0)
        if backwards:  # starts at its end, here, and keeps its direction and its yaw
            np.testing.assert_allclose(start.pos, here)
            np.testing.assert_allclose(later.pos, here - [1.0, 0.0, 0.0])
            assert start.yaw == pytest.approx(0.3)
        else:  # a quarter turn about the origin takes (2, 1) to (-1, 2)
            np.testing.assert_allclose(
                start.pos, here + np.array([-1.0 - 2.0, 2.0 - 1.0, 0.0]), atol=3 * YAW_32
            )
            np.testing.assert_allclose(later.pos - start.pos, [0.0, 1.0, 0.0], atol=3 * YAW_32)
            assert start.yaw == pytest.approx(0.3 + math.pi / 2)


@pytest.mark.parametrize("asked", [math.pi, -math.pi])
def test_half_a_turn_is_flown_to_the_right_whichever_way_it_is_asked_for(asked: float) -> None:
    planner = Planner()
    planner.go_to(Target((0.0, 0.0, 1.0), float(np.float32(asked)), 2.0), 0.0)
    assert planner.goal(2.0).yaw == pytest.approx(-math.pi)
    assert planner.goal(1.0).yaw == pytest.approx(-math.pi / 2)


def test_a_goal_that_is_no_number_disables_the_planner_until_the_next_command() -> None:
    planner = Planner()
    assert planner.go_to(Target((1.0, 0.0, 1.0), 0.0, 0.0, linear=True), 0.0) == PlannerResult.OK
    assert planner.goal(0.01) is None
    assert planner.state == PlanState.DISABLED
    assert planner.take_off(Vertical(1.0, 1.0), 0.1) == PlannerResult.WRONG_STATE
    planner.go_to(Target((1.0, 0.0, 1.0), 0.0, 2.0), 0.1)
    np.testing.assert_allclose(planner.goal(3.0).pos, [1.0, 0.0, 1.0])


@pytest.mark.parametrize(
    ("clockwise", "sideways"), [(False, False), (True, False), (False, True), (True, True)]
)
def test_a_quarter_circle_keeps_its_radius_and_its_speed(clockwise: bool, sideways: bool) -> None:
    here = goal_at_rest(np.array([1.0, 2.0, 1.0]), 0.4)
    radius, duration = 0.5, 2.0
    piece = spiral_piece(here, Spiral(math.pi / 2, radius, radius, 0.2, duration, sideways, clockwise))
    first, last = goal_at(piece, 0.0), goal_at(piece, duration)
    to_left = np.array([-first.vel[1], first.vel[0]]) / np.linalg.norm(first.vel[:2])
    centre = here.pos[:2] + radius * to_left * (-1.0 if clockwise else 1.0)
    for tau in np.linspace(0.0, duration, 9):
        goal = goal_at(piece, tau)
        away = np.linalg.norm(goal.pos[:2] - centre)
        assert away == pytest.approx(radius, rel=0.01)  # no jerk at its ends, so no exact circle
        assert np.linalg.norm(goal.vel[:2]) == pytest.approx(radius * math.pi / 2 / duration, rel=0.05)
    assert last.pos[2] - first.pos[2] == pytest.approx(0.2)
    assert last.yaw - first.yaw == pytest.approx((-1.0 if clockwise else 1.0) * math.pi / 2)
    ahead = np.array([math.cos(0.4), math.sin(0.4)]) @ first.vel[:2] / np.linalg.norm(first.vel[:2])
    assert abs(ahead) == pytest.approx(0.0 if sideways else 1.0, abs=YAW_32)
    if not sideways:
        assert ahead > 0.0


def test_cflibs_high_level_commands_reach_the_planner(grounded: CflibFleet) -> None:
    commander = pytest.importorskip("cflib.crazyflie.high_level_commander").HighLevelCommander
    wire = grounded.wire()
    crazyflies = commander(wire)
    planner = grounded.firmware().planner
    crazyflies.takeoff(1.0, 2.0, yaw=None)
    assert planner.state == PlanState.FLYING
    assert wire.answers[-1] == wire.sent[-1][:4] + b"\0"
    assert planner.goal(grounded.firmware().seconds + 2.0).pos[2] == pytest.approx(1.0)
    crazyflies.go_to(1.0, 2.0, 3.0, 0.5, 4.0, relative=True, linear=False)
    end = planner.goal(grounded.firmware().seconds + 4.0)
    np.testing.assert_allclose(end.pos, [1.0, 2.0, 3.0], atol=1e-6)  # from the ground; 32-bit floats
    crazyflies.spiral(math.pi, 1.0, 1.0, 0.0, 3.0)
    assert planner.goal(grounded.firmware().seconds + 3.0).yaw == pytest.approx(0.5 + math.pi, abs=1e-6)
    crazyflies.land(0.0, 2.0)
    assert planner.state == PlanState.LANDING
    crazyflies.stop()
    assert planner.state == PlanState.IDLE


def test_a_group_mask_keeps_commands_from_vehicles_of_other_groups(grounded: CflibFleet) -> None:
    commander = pytest.importorskip("cflib.crazyflie.high_level_commander").HighLevelCommander
    crazyflies = commander(grounded.wire())
    crazyflies.set_group_mask(0b0010)
    crazyflies.takeoff(1.0, 2.0, group_mask=0b0100)
    assert grounded.firmware().planner.state == PlanState.IDLE
    crazyflies.takeoff(1.0, 2.0, group_mask=0b0110)
    assert grounded.firmware().planner.state == PlanState.FLYING


def test_an_uploaded_trajectory_is_flown_and_an_unsound_one_is_refused(grounded: CflibFleet) -> None:
    commander = pytest.importorskip("cflib.crazyflie.high_level_commander").HighLevelCommander
    wire = grounded.wire()
    crazyflies = commander(wire)
    rise = np.zeros((4, 8), dtype="<f4")
    rise[2, 1] = 0.5
    packed = rise.tobytes() + struct.pack("<f", 2.0)
    for at in range(0, len(packed), 24):
        grounded.fleet.vehicles[0].handle(b"\x4e\x00" + struct.pack("<I", at) + packed[at : at + 24])
    crazyflies.define_trajectory(3, 0, 1)
    crazyflies.start_trajectory(3)
    assert wire.answers[-1][-1] == PlannerResult.OK
    goal = grounded.firmware().planner.goal(grounded.firmware().seconds + 1.0)
    np.testing.assert_allclose((goal.pos[2], goal.vel[2]), (0.5, 0.5))
    for number, pieces in ((4, 0), (5, 40)):  # none, beyond the memory
        crazyflies.define_trajectory(number, 0, pieces)
        crazyflies.start_trajectory(number)
        assert wire.answers[-1][-1] == PlannerResult.UNKNOWN


def test_a_compressed_trajectory_of_cflib_is_flown_along_its_bezier_curves(grounded: CflibFleet) -> None:
    """Axes constant, linear, cubic and of degree 7, in two segments, against scipy's BPoly."""
    memory = pytest.importorskip("cflib.crazyflie.mem")
    commander = pytest.importorskip("cflib.crazyflie.high_level_commander").HighLevelCommander
    cubic, seventh = [0.5, 1.0, 1.5], [0.1, 0.2, 0.4, 0.8, 1.0, 1.1, 1.2]
    segments = [
        memory.CompressedSegment(2.0, [1.0], cubic, seventh, []),
        memory.CompressedSegment(0.5, [], [0.25], [], []),
    ]
    packed = b"".join(one.pack() for one in [memory.CompressedStart(0.0, 0.0, 0.25, 0.0), *segments])
    for at in range(0, len(packed), 24):
        grounded.fleet.vehicles[0].handle(b"\x4e\x00" + struct.pack("<I", at) + packed[at : at + 24])
    wire, firmware = grounded.wire(), grounded.firmware()
    crazyflies = commander(wire)
    crazyflies.define_trajectory(3, 0, 3, type=1)
    crazyflies.start_trajectory(3)
    assert wire.answers[-1][-1] == PlannerResult.OK
    curves = [BPoly(np.c_[axis], [0.0, 2.0]) for axis in ([0.0, 1.0], [0.0, *cubic], [0.25, *seventh])]
    for since in (0.0, 0.7, 1.9):
        goal = firmware.planner.goal(firmware.seconds + since)
        np.testing.assert_allclose(goal.pos, [one(since) for one in curves], atol=1e-6)
        np.testing.assert_allclose(goal.vel, [one(since, 1) for one in curves], atol=1e-6)
    for since, y in ((2.25, 0.875), (9.0, 0.25)):  # the second segment, and at rest
        goal = firmware.planner.goal(firmware.seconds + since)
        np.testing.assert_allclose((*goal.pos, goal.yaw), [1.0, y, 1.2, 0.0], atol=1e-6)
    for how in ({"time_scale": 2.0}, {"reversed": True}):
        crazyflies.start_trajectory(3, **how)
        assert wire.answers[-1][-1] == PlannerResult.UNKNOWN


def test_a_compressed_trajectory_turns_as_the_firmware_does_and_needs_an_end() -> None:
    """A quarter turn is 900 tenths of a degree, which the firmware takes for 9000 rad."""
    ends = bytes(3)
    one = struct.pack("<4hBHh", 0, 0, 0, 0, 0b01000000, 1000, 900) + ends
    assert compressed_pieces(one, 0)[0].coefficients[3].tolist() == [0.0, 9000.0, *[0.0] * 6]
    resting = compressed_pieces(struct.pack("<4h", 500, 0, 0, 0) + ends, 0)
    assert (resting[0].duration, resting[0].coefficients[0, 0]) == (0.0, 0.5)
    for lacking in (one[:-1], one[:12], b""):
        with pytest.raises(ValueError, match="has no end in the memory"):
            compressed_pieces(lacking, 0)


def test_an_undefined_trajectory_is_answered_and_not_flown_and_31_can_be_defined(
    grounded: CflibFleet,
) -> None:
    commander = pytest.importorskip("cflib.crazyflie.high_level_commander").HighLevelCommander
    wire = grounded.wire()
    crazyflies, planner = commander(wire), grounded.firmware().planner
    crazyflies.start_trajectory(9)
    assert (wire.answers[-1][-1], planner.state) == (PlannerResult.OK, PlanState.IDLE)
    for number, answer in ((30, PlannerResult.OK), (31, PlannerResult.UNKNOWN)):
        crazyflies.define_trajectory(number, 0, 1)
        assert wire.answers[-1][-1] == answer
    crazyflies.start_trajectory(31)
    assert (wire.answers[-1][-1], planner.state) == (PlannerResult.OK, PlanState.IDLE)


def test_a_command_of_more_than_an_hour_is_taken(grounded: CflibFleet) -> None:
    commander = pytest.importorskip("cflib.crazyflie.high_level_commander").HighLevelCommander
    wire, firmware = grounded.wire(), grounded.firmware()
    commander(wire).takeoff(1.0, 7200.0)
    assert wire.answers[-1][-1] == PlannerResult.OK
    assert firmware.planner.goal(firmware.seconds + 3600.0).pos[2] == pytest.approx(0.5)
