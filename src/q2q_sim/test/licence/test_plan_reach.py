"""Reach of a vehicle: a free fall, a climb at full thrust, and jumps, against their closed forms."""

import math
import struct

import numpy as np
import pytest

from cflib_fleet import CflibFleet
from q2q_model.vehicle.constants import CRAZYFLIE_2_0, GRAVITY
from q2q_sim.crtp.packets.packet import Packet, Port, datagram_of, packet_of
from q2q_sim.crtp.ports import memory
from q2q_sim.firmware.commander.piecewise import Piecewise
from q2q_sim.firmware.commander.planner import PlanState
from q2q_sim.firmware.commander.polynomial import Goal, Piece, goal_at_rest, piece_between
from q2q_sim.licence.client_commands.packet_command import client_command
from q2q_sim.licence.client_commands.plan_extent import plan_extent
from q2q_sim.licence.client_commands.plan_reach import distance_beyond_reach, reach_violation
from q2q_sim.licence.crazyflie_py import server_packets

FULL = CRAZYFLIE_2_0.thrust_max / CRAZYFLIE_2_0.mass
"""Full thrust over the mass [m/s^2]."""


def rest_to_rest(x: float, y: float, z: float, duration: float) -> Piece:
    return piece_between(goal_at_rest(np.zeros(3), 0.0), goal_at_rest(np.array([x, y, z]), 0.0), duration)


def test_the_reach_is_that_of_full_thrust_up_down_and_aside():
    up, down = 0.5 * (FULL - GRAVITY) * 0.25, 0.5 * (FULL + GRAVITY) * 0.25
    aside = math.sqrt(FULL**2 - GRAVITY**2) * 0.5 * 0.25
    for end in ((0.0, 0.0, up), (0.0, 0.0, -down), (aside, 0.0, 0.0), (0.0, -aside, 0.0)):
        assert distance_beyond_reach(rest_to_rest(*end, 0.5), 1.0, CRAZYFLIE_2_0) == pytest.approx(
            0.0, abs=1e-9
        )
    beyond = distance_beyond_reach(rest_to_rest(0.0, 0.0, up + 0.2, 0.5), 1.0, CRAZYFLIE_2_0)
    assert beyond == pytest.approx(0.2)
    assert distance_beyond_reach(rest_to_rest(0.0, 0.0, up + 0.2, 0.25), 2.0, CRAZYFLIE_2_0) == pytest.approx(
        0.2
    )


def test_initial_speed_extends_the_reach():
    start = Goal(np.zeros(3), np.array([5.0, 0.0, 0.0]), np.zeros(3), 0.0, np.zeros(3))
    end = Goal(np.array([1.0, 0.0, 0.0]), np.array([5.0, 0.0, 0.0]), np.zeros(3), 0.0, np.zeros(3))
    piece = piece_between(start, end, 0.2)
    expected = 0.5 * (GRAVITY - FULL) * 0.04  # only the weight is to be carried
    assert distance_beyond_reach(piece, 1.0, CRAZYFLIE_2_0) == pytest.approx(expected)
    slower = 0.5 * (GRAVITY - FULL) * 0.16
    assert distance_beyond_reach(piece, 2.0, CRAZYFLIE_2_0) == pytest.approx(slower)


def test_a_short_step_a_quick_one_and_a_jump_are_told_apart():
    def refusal(*pieces: Piece, backwards: bool = False) -> str:
        return reach_violation(Piecewise(pieces, 0.0, backwards=backwards), np.zeros(3), CRAZYFLIE_2_0)

    assert refusal(rest_to_rest(0.05, 0.0, 0.0, 0.05)) == ""  # a small step of a PositionHlCommander
    assert refusal(rest_to_rest(0.0, 0.0, 0.5, 0.5)) == ""
    beyond = math.hypot(2.0, 0.5 * GRAVITY * 0.16) - 0.5 * FULL * 0.16
    assert refusal(rest_to_rest(2.0, 0.0, 0.0, 0.4)).startswith(f"a position {beyond:.2f} m beyond")
    first, second = rest_to_rest(1.0, 0.0, 0.0, 2.0), rest_to_rest(0.0, 0.0, 0.0, 2.0)
    for backwards in (False, True):
        jumps = refusal(first, second, backwards=backwards)
        assert jumps == "a trajectory that jumps by 1.00 m between two pieces"
    assert refusal(second, rest_to_rest(1.0, 0.0, 0.0, 2.0)) == ""
    nothing = Piece(2.0, np.full((4, 8), math.nan))
    assert refusal(nothing, nothing).startswith("a position that is not finite")


@pytest.mark.parametrize("duration", [0.0, -1.0])
def test_a_plan_without_duration_is_away_by_its_distance_to_the_goal_before(duration: float):
    here = np.array([0.5, -0.3, 1.0])

    def refusal(x: float, y: float, z: float) -> str:
        return reach_violation(Piecewise((rest_to_rest(x, y, z, duration),), 3.0), here, CRAZYFLIE_2_0)

    assert refusal(0.5, -0.3, 1.0) == refusal(0.5, -0.3, 1.14) == refusal(0.36, -0.3, 1.0) == ""
    farther = "m beyond the reach of full thrust in that time"
    assert refusal(0.5, 0.9, 0.5) == f"a position 1.30 {farther}"
    assert refusal(0.5, -0.3, 1.16) == f"a position 0.16 {farther}"


def hovering(height: float) -> CflibFleet:
    """Return a vehicle whose high-level commander has taken it to a height and keeps it there."""
    crazyflies = CflibFleet(np.array([[0.2, 0.0, height, 0.0]]))
    crazyflies.fly(0.1)
    rise = server_packets.vertical(server_packets.TAKE_OFF, height, 1.0, 0)
    crazyflies.fleet.vehicles[0].handle(datagram_of(rise))
    crazyflies.fly(0.5)
    return crazyflies


def impossible(crazyflies: CflibFleet, packet: Packet) -> str:
    """Return what of a command a vehicle cannot follow."""
    answers = crazyflies.fleet.vehicles[0].handle(datagram_of(packet))
    asked = client_command(packet, [packet_of(one) for one in answers], crazyflies.firmware())
    if asked is None:
        return ""
    assert asked.refused == ""
    return asked.impossible


def test_commands_in_zero_seconds_are_told_by_how_far_they_take_the_goal():
    def go(x: float, z: float, *, relative: bool = False) -> Packet:
        return server_packets.go_to((x, 0.0, z), 0.0, 0.0, relative=relative, mask=0)

    crazyflies = hovering(1.0)
    assert impossible(crazyflies, go(0.2, 1.0)) == ""
    assert impossible(crazyflies, go(0.0, 0.0, relative=True)) == ""
    assert impossible(crazyflies, go(1.7, 1.0)).startswith("a position 1.50 m beyond")
    crazyflies = hovering(1.0)
    assert impossible(crazyflies, go(0.0, 0.5, relative=True)).startswith("a position 0.50 m beyond")
    crazyflies.fly(0.02)  # the goal is there now, the vehicle is not
    assert impossible(crazyflies, go(0.0, 0.0, relative=True)) == ""


@pytest.mark.parametrize(
    "content",
    [
        struct.pack("<BBBB5f", 12, 0, 0, 1, 0.2, 0.0, 1.5, 0.0, 0.0),  # go_to, linear
        struct.pack("<BBBB5f", 11, 0, 0, 0, 1.0, 0.5, 0.5, 0.0, 0.0),  # spiral
    ],
)
def test_a_line_and_a_spiral_in_zero_seconds_have_no_place(content: bytes):
    crazyflies = hovering(1.0)
    told = "a position that is not finite, like that of a line or spiral in 0 s: it drops the plan"
    assert impossible(crazyflies, Packet(Port.HIGH_LEVEL, 0, content)) == told
    crazyflies.fly(0.01)
    assert crazyflies.firmware().planner.state == PlanState.DISABLED


def test_a_take_off_in_zero_seconds_is_a_jump_and_a_landing_in_zero_seconds_stops_the_motors(
    grounded: CflibFleet,
):
    jump = server_packets.vertical(server_packets.TAKE_OFF, 0.4, 0.0, 0)
    assert impossible(grounded, jump).startswith("a position 0.40 m beyond")
    crazyflies = hovering(1.0)
    assert impossible(crazyflies, server_packets.vertical(server_packets.LAND, 0.0, 0.0, 0)) == ""
    crazyflies.fly(0.01)
    assert crazyflies.firmware().planner.state == PlanState.IDLE


def test_an_uploaded_trajectory_that_begins_away_from_the_goal_is_told_by_how_far():
    level = np.zeros((4, 8))
    level[2, 0] = 1.0  # at rest at (0, 0, 1)
    for relative, told in ((False, "a trajectory that begins 0.20 m from its position"), (True, "")):
        crazyflies = hovering(1.0)  # at x = 0.2
        for packet in server_packets.upload(1, 0, [(2.0, level)]):
            assert not impossible(crazyflies, packet)
        start = server_packets.start(1, 1.0, backwards=False, relative=relative, mask=0)
        assert impossible(crazyflies, start) == told


def test_a_trajectory_that_is_started_during_its_upload_is_told():
    crazyflies = hovering(1.0)
    *written, defined = server_packets.upload(3, 1, [(1.0, np.ones((4, 8)) * 1e-3)] * 4)
    start = server_packets.start(3, 1.0, backwards=False, relative=True, mask=0)
    half = len(written) // 2  # two pieces
    for packet in (*written[:half], defined):
        assert not impossible(crazyflies, packet)
    assert impossible(crazyflies, start) == "trajectory 3, with 2 of 4 pieces not uploaded"
    changes = "a change of the trajectory it is flying"
    assert {impossible(crazyflies, packet) for packet in written[half:]} == {changes}
    (other,) = list(server_packets.upload(4, 0, [(1.0, np.ones((4, 8)))]))[:1]
    assert impossible(crazyflies, other) == ""  # before its first piece
    crazyflies.fly(4.1)
    assert impossible(crazyflies, written[0]) == ""  # it is over


def test_a_piece_of_no_duration_that_was_uploaded_is_there():
    """The firmware steps over it."""
    coefficients = np.ones((4, 8)) * 1e-4
    crazyflies = hovering(1.0)
    for packet in server_packets.upload(1, 0, [(1.0, coefficients), (0.0, coefficients)]):
        assert not impossible(crazyflies, packet)
    start = server_packets.start(1, 1.0, backwards=False, relative=True, mask=0)
    assert impossible(crazyflies, start) == ""


def test_a_compressed_trajectory_that_was_not_uploaded_is_told():
    crazyflies = hovering(1.0)
    define = Packet(Port.HIGH_LEVEL, 0, struct.pack("<BBBBIB", 6, 3, 1, 1, 0, 1))
    assert not impossible(crazyflies, define)
    start = server_packets.start(3, 1.0, backwards=False, relative=True, mask=0)
    assert impossible(crazyflies, start) == "trajectory 3, with 1 of 1 pieces not uploaded"


def test_a_change_of_a_compressed_trajectory_that_is_flown_is_told():
    """One segment of 2 s that rises by two control points on x, and its end mark: 8 + 3 + 3 * 2 + 3 bytes."""
    packed = struct.pack("<4hBH3hBH", 200, 0, 1000, 0, 0b10, 2000, 200, 210, 220, 0, 0)
    crazyflies, at = hovering(1.0), 100  # at x = 0.2

    def write(place: int, content: bytes) -> Packet:
        return Packet(Port.MEMORY, memory.WRITE, struct.pack("<BI", 0, place) + content)

    for packet in (write(at, packed), Packet(Port.HIGH_LEVEL, 0, struct.pack("<BBBBIB", 6, 3, 1, 1, at, 1))):
        assert not impossible(crazyflies, packet)
    assert not impossible(crazyflies, server_packets.start(3, 1.0, backwards=False, relative=False, mask=0))
    changes = "a change of the trajectory it is flying"
    writes = {at - 1: "", at: changes, at + len(packed) - 1: changes, at + len(packed): ""}
    assert {place: impossible(crazyflies, write(place, b"\1")) for place in writes} == writes
    crazyflies.fly(2.1)
    assert impossible(crazyflies, write(at, b"\2")) == ""  # it is over


def test_the_same_upload_again_is_no_change_of_the_trajectory_that_is_flown():
    crazyflies = hovering(1.0)
    *written, defined = server_packets.upload(3, 0, [(5.0, np.ones((4, 8)) * 1e-6)])
    start = server_packets.start(3, 1.0, backwards=False, relative=True, mask=0)
    *other, _ = server_packets.upload(3, 0, [(5.0, np.ones((4, 8)) * 2e-6)])
    assert {impossible(crazyflies, packet) for packet in (*written, defined, start, *written)} == {""}
    assert {impossible(crazyflies, packet) for packet in other} == {"a change of the trajectory it is flying"}


@pytest.mark.parametrize("arrived", range(6))
def test_a_piece_of_which_packets_have_not_arrived_is_not_uploaded(arrived: int) -> None:
    crazyflies = hovering(1.0)
    *written, defined = server_packets.upload(3, 0, [(1.0, np.ones((4, 8)) * 1e-3)])
    assert len(written) == 6
    for packet in (*written[:arrived], defined):
        assert not impossible(crazyflies, packet)
    start = server_packets.start(3, 1.0, backwards=False, relative=True, mask=0)
    assert impossible(crazyflies, start) == "trajectory 3, with 1 of 1 pieces not uploaded"


def test_an_upload_changes_no_trajectory_that_was_left_for_setpoints():
    crazyflies = hovering(1.0)
    *written, defined = server_packets.upload(3, 0, [(10.0, np.ones((4, 8)) * 1e-6)])
    for packet in (*written, defined):
        assert not impossible(crazyflies, packet)
    assert not impossible(crazyflies, server_packets.start(3, 1.0, backwards=False, relative=True, mask=0))
    first, second, *_ = server_packets.upload(4, 0, [(10.0, np.ones((4, 8)) * 2e-6)])
    assert impossible(crazyflies, first) == "a change of the trajectory it is flying"
    impossible(crazyflies, server_packets.position((0.2, 0.0, 1.0), 0.0))
    crazyflies.fly(0.1)
    assert impossible(crazyflies, second) == ""


def test_the_extent_of_a_plan_is_that_of_all_its_goals_shifted_and_turned():
    dip = (rest_to_rest(1.0, 0.0, -0.5, 3.0), piece_between(
        goal_at_rest(np.array([1.0, 0.0, -0.5]), 0.0), goal_at_rest(np.zeros(3), 0.0), 3.0
    ))  # fmt: skip
    low, high = plan_extent(Piecewise(dip, 7.0, timescale=2.0, shift=(0.0, 0.0, 0.4), turn=0.5 * math.pi))
    np.testing.assert_allclose([low, high], [[0.0, 0.0, -0.1], [0.0, 1.0, 0.4]], atol=1e-9)


def test_the_extent_of_a_bow_is_found_to_within_5_mm():
    bow = np.zeros((4, 8))
    bow[0, :3] = 0.0, 4.0, -4.0  # x = 4 t (1 - t): 1 m between its ends, at 0.5 of the piece
    bow[1, 1] = 1.0
    low, high = plan_extent(Piecewise((Piece(0.97, bow),), 0.0))
    assert low == pytest.approx((0.0, 0.0, 0.0))
    assert high == pytest.approx((1.0, 0.97, 0.0), abs=5e-3)


def test_a_relative_go_to_asks_for_the_places_that_it_leads_through():
    crazyflies = hovering(0.5)  # at x = 0.2
    down = server_packets.go_to((0.0, 1.0, -0.9), 0.0, 2.0, relative=True, mask=0)
    answers = crazyflies.fleet.vehicles[0].handle(datagram_of(down))
    asked = client_command(down, [packet_of(one) for one in answers], crazyflies.firmware())
    assert asked is not None
    assert asked.extent is not None
    np.testing.assert_allclose(asked.extent, [[0.2, 0.0, -0.4], [0.2, 1.0, 0.5]], atol=0.02)
