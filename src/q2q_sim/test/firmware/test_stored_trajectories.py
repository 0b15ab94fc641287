"""Trajectories in a vehicle's memory: shifted, turned, slowed and reversed, or refused."""

import math
import struct

import numpy as np
import pytest
from scipy.interpolate import BPoly
from yaw_rounding import YAW_32

from cflib_fleet import CflibFleet
from q2q_sim.firmware.commander.compressed_pieces import compressed_pieces
from q2q_sim.firmware.commander.piecewise import Piecewise
from q2q_sim.firmware.commander.planner import Begin, Planner, PlannerResult, PlanState
from q2q_sim.firmware.commander.polynomial import Piece


def upload(crazyflies: CflibFleet, packed: bytes) -> None:
    """Write bytes to the trajectory memory of the first vehicle."""
    for at in range(0, len(packed), 24):
        crazyflies.fleet.vehicles[0].handle(b"\x4e\x00" + struct.pack("<I", at) + packed[at : at + 24])


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


def test_an_uploaded_trajectory_is_flown_and_an_unsound_one_is_refused(grounded: CflibFleet) -> None:
    commander = pytest.importorskip("cflib.crazyflie.high_level_commander").HighLevelCommander
    wire = grounded.wire()
    crazyflies = commander(wire)
    rise = np.zeros((4, 8), dtype="<f4")
    rise[2, 1] = 0.5
    packed = rise.tobytes() + struct.pack("<f", 2.0)
    upload(grounded, packed)
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
    upload(grounded, packed)
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
        with pytest.raises(ValueError, match="does not end within the memory"):
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


@pytest.mark.parametrize(
    "yaw", [b"\x00\x00\x80\x7f", b"\x01\x00\xa0\x7f"], ids=["infinity", "signalling NaN"]
)
def test_an_uploaded_yaw_of_no_number_is_computed_as_in_c_without_a_warning(
    grounded: CflibFleet, yaw: bytes
) -> None:
    upload(grounded, struct.pack("<24f", *[0.0] * 24) + yaw + struct.pack("<8f", *[0.0] * 7, 1.0))
    vehicle = grounded.fleet.vehicles[0]
    vehicle.handle(b"\x8c" + struct.pack("<BBBBIB", 6, 1, 1, 0, 0, 1))
    answer = vehicle.handle(b"\x8c" + struct.pack("<6Bf", 13, 0, 1, 1, 0, 1, 1.0))
    assert answer == [b"\x8c\x0d\x00\x01\x00"]
    assert grounded.firmware().planner.goal(grounded.firmware().seconds) is None
    assert grounded.firmware().planner.state == PlanState.DISABLED
