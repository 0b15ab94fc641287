"""Motions are reckoned from commands, and the trim of vehicles is learned while they are measured."""

import numpy as np
import pytest
from reckoned_flights import HOVER, LEVEL, TICK, LostVehicle, flown, level_at, state_at, ticked

from q2q_control.failsafe.tracking_loss.dead_reckoned_braking import DeadReckonedBraking
from q2q_control.failsafe.tracking_loss.dead_reckoning import (
    LAG_S,
    TILT_SQUARE,
    TRACK_WIDTH,
    TRIM,
    TRIM_MAX,
    VEL,
    AppliedCommand,
    MeasuredState,
    _tilted,
    reckon,
)
from q2q_model.estimation.mocap_filter_params import MocapFilterParams
from q2q_model.signals.values import CommandStatus, TrackStatus
from q2q_model.vehicle.constants import GRAVITY


def test_a_weak_vehicle_gains_as_much_by_its_tilt_as_its_thrust_holds() -> None:
    """With 1.2 m/s^2 of trim, a thrust that holds the weight accelerates by g tan(tilt), as without."""
    for weak in (0.0, 1.2):
        track = np.zeros((1, TRACK_WIDTH))
        track[0, TRIM + 2] = weak
        share = (1.0 + weak / GRAVITY) / np.cos(0.2)
        applied = AppliedCommand(np.array([share]), np.zeros(1), np.array([0.2]))
        lost = np.array([TrackStatus.LOST], dtype=np.uint8)
        unseen = MeasuredState(np.zeros((1, 3)), np.zeros((1, 3)), LEVEL, lost)
        for _ in range(300):
            before = track[0, VEL]
            reckon(track, applied, np.zeros((1, 3)), TICK, unseen)
        assert (track[0, VEL] - before) / TICK == pytest.approx(GRAVITY * np.tan(0.2), rel=1e-4)
        assert track[0, VEL + 2] == pytest.approx(0.0, abs=1e-9 if not weak else 0.2)


def test_a_command_that_was_held_while_frames_were_late_counts_for_all_of_it() -> None:
    """Frames stopped for 0.25 s while a vehicle leaned: it is reckoned as one of which every tick came."""
    speeds = []
    for gap in (TICK, 0.25):
        block = DeadReckonedBraking(HOVER)
        block.update(state_at(0.0, np.zeros(2)), level_at(0.0, CommandStatus.OK, roll=0.3))
        for k in range(1, round(0.5 / gap) + 1):
            t = k * gap
            for _ in range(round(gap / TICK) - 1):
                block.wait()
            block.advance(state_at(t, np.zeros(2), age=t), None, t)
            block.record_nominal(state_at(t, np.zeros(2)), level_at(t, CommandStatus.OK, roll=0.3))
        speeds.append(block.predicted(state_at(0.5, np.zeros(2), age=0.5)).vel[0, 1])
    assert speeds[0] == pytest.approx(-GRAVITY * np.sin(0.3) * (0.5 - LAG_S), rel=0.1)
    assert speeds[1] == pytest.approx(speeds[0], rel=1e-9)


def test_a_clock_set_ahead_while_a_vehicle_leans_unseen_is_not_flown() -> None:
    """Stamps leap by 0.34 s: it is reckoned as one whose clock did not."""
    speeds = []
    for leap in (0.0, 0.34):
        block, t = DeadReckonedBraking(HOVER), 0.0
        block.update(state_at(t, np.zeros(2)), level_at(t, CommandStatus.OK, roll=0.3))
        for k in range(1, 31):
            t = k * TICK + (leap if k >= 10 else 0.0)
            block.advance(state_at(t, np.zeros(2), age=t), None, t)
            block.record_nominal(state_at(t, np.zeros(2)), level_at(t, CommandStatus.OK, roll=0.3))
        speeds.append(block.predicted(state_at(t, np.zeros(2), age=t)).vel[0, 1])
    assert speeds[1] == pytest.approx(speeds[0], rel=1e-6)


@pytest.mark.parametrize("yaw", [0.0, 0.7, -2.5])
@pytest.mark.parametrize("tilt", [0.0, 2.0])
def test_where_who_is_not_seen_is_and_that_it_comes_to_rest_is_known(yaw: float, tilt: float) -> None:
    plant = LostVehicle(np.array([0.4, -0.3, 0.0]), yaw, np.zeros(3))
    found = flown(plant, np.array([[tilt, 0.0, 0.0]]), (20, 280))
    ways, reckoned = found[:, :6], found[:, 6:]
    # the plant's thrust tilts with its body, steps of 1 ms against ticks
    np.testing.assert_allclose(reckoned, ways, atol=0.03)
    assert np.linalg.norm(ways[-1, :2] - ways[0, :2]) > 0.15
    np.testing.assert_allclose(ways[-1, 3:], 0.0, atol=0.02)


WINDS = {"none": np.zeros(3), "wind": np.array([0.5, -0.3, 0.0]), "downwash": np.array([0.0, 0.0, -2.0])}


@pytest.mark.parametrize("push", WINDS.values(), ids=WINDS)
@pytest.mark.parametrize("offset", [0.0, 0.05], ids=["true", "trimmed"])
def test_the_trim_is_kept_without_measurements(push: np.ndarray, offset: float) -> None:
    """A steady push, and a vehicle that leans when it is told to be level."""
    plant = LostVehicle(np.zeros(3), 0.4, push, offset)
    frame = np.array([[np.cos(0.4), np.sin(0.4), 0.0], [-np.sin(0.4), np.cos(0.4), 0.0], [0.0, 0.0, 1.0]])
    sideways = np.array([0.0, (GRAVITY - push[2]) * np.sin(offset), 0.0])  # of the thrust that it flies at
    found = flown(plant, (sideways - frame @ push)[None], (600, 100))
    untrimmed = np.linalg.norm(push + sideways)  # [m/s], in a second
    assert np.linalg.norm(found[-1, 3:6]) < 0.03 + 0.03 * untrimmed
    np.testing.assert_allclose(found[:, 6:9], found[:, :3], atol=0.04)


@pytest.mark.parametrize("since", [0.1, 0.3, 0.6])
def test_a_first_trim_is_the_slope_of_all_velocities_so_far_and_a_prior(since: float) -> None:
    """A level vehicle drifts ever faster: the fit of its slope, shrunk to 0 as if it were known for LAG_S."""
    slope, track = np.array([0.3, -0.2, 0.0]), np.zeros((1, TRACK_WIDTH))
    level = AppliedCommand(np.ones(1), np.zeros(1), np.zeros(1))
    for k in range(round(since / TICK) + 1):
        vel = (slope * k * TICK)[None]
        state = MeasuredState(np.zeros((1, 3)), vel, LEVEL, np.zeros(1, dtype=np.uint8))
        reckon(track, level, np.zeros((1, 3)), TICK if k else 0.0, state)
    learned = since**3 / (since**3 + LAG_S**3)
    np.testing.assert_allclose(track[0, TRIM : TRIM + 3], -learned * slope, rtol=0.15, atol=1e-12)


def test_an_acceleration_that_is_wanted_is_no_trim() -> None:
    """To and fro, up and down: the vehicle does what it is told to."""
    plant = LostVehicle(np.zeros(3), 0.0, np.zeros(3))
    wanted = np.repeat([[1.0, 0.0, 1.5], [-1.0, 0.0, -1.5], [-1.0, 0.0, -1.5], [1.0, 0.0, 1.5]], 20, axis=0)
    found = flown(plant, wanted, (340, 100))
    np.testing.assert_allclose(found[-1, 3:6], 0.0, atol=0.12)
    np.testing.assert_allclose(found[:, 6:9], found[:, :3], atol=0.05)


@pytest.mark.parametrize("share", [0.0, 2.0])
def test_no_more_is_trimmed_than_a_vehicle_may_be_given(share: float) -> None:
    """A vehicle that does not move with its motors off, or at twice its weight: it is held."""
    track = np.zeros((1, TRACK_WIDTH))
    state = MeasuredState(np.zeros((1, 3)), np.zeros((1, 3)), LEVEL, np.zeros(1, np.uint8))
    for _ in range(300):
        applied = AppliedCommand(np.full(1, share), np.zeros(1), np.zeros(1))
        reckon(track, applied, np.zeros((1, 3)), TICK, state)
    assert track[0, TRIM + 2] == np.sign(share - 1.0) * TRIM_MAX[1]
    np.testing.assert_array_equal(track[0, TRIM : TRIM + 2], 0.0)


@pytest.mark.parametrize("speed", [3.0, 1e300, np.inf, np.nan])
def test_a_velocity_that_jumps_is_no_trim(speed: float) -> None:
    """A track that restarts, or a state that means nothing, for 0.1 s."""
    track, level = np.zeros((1, TRACK_WIDTH)), AppliedCommand(np.ones(1), np.zeros(1), np.zeros(1))
    for k in range(100):
        vel = np.full((1, 3), speed if 50 <= k < 60 else 0.0)
        state = MeasuredState(np.zeros((1, 3)), vel, LEVEL, np.zeros(1, np.uint8))
        reckon(track, level, np.zeros((1, 3)), TICK, state)
    np.testing.assert_array_equal(track[0, VEL : VEL + 3], 0.0)
    np.testing.assert_array_equal(track[0, TRIM : TRIM + 3], 0.0)


def test_in_a_gap_between_ticks_a_tilt_is_taken_as_flown_for_as_long_as_a_vehicle_coasts_at_most() -> None:
    def reckoned(gap: float) -> np.ndarray:
        block, leaning = DeadReckonedBraking(HOVER), level_at(0.0, CommandStatus.OK, roll=0.2)
        block.update(state_at(0.0, np.array([1.0, 0.0])), leaning)
        lost = state_at(gap, np.zeros(2), age=gap)
        ticked(block, lost, level_at(gap, CommandStatus.HOLD, roll=0.2))
        return block.reckoned(("cf1",))["cf1"].pos

    assert reckoned(0.05)[0] == pytest.approx(0.05)
    np.testing.assert_array_equal(reckoned(MocapFilterParams().coast_s), reckoned(2.0))


def test_a_tilt_follows_by_its_equations_of_any_step() -> None:
    """Their solution over 0.3 s, in one step and in thirty, against steps of 10 us."""
    left, jerk, gained = 2.0, -5.0, 0.0
    for _ in range(30_000):
        jerk += 1e-5 * TILT_SQUARE * (-left - LAG_S * jerk)
        gained += 1e-5 * left
        left += 1e-5 * jerk
    one = _tilted(2.0, -5.0, 0.3)
    np.testing.assert_allclose(one, (left, jerk, gained), atol=1e-3)  # the step, times the largest rate
    left, jerk, gained = 2.0, -5.0, 0.0
    for _ in range(30):
        left, jerk, more = _tilted(left, jerk, 0.01)
        gained += more
    np.testing.assert_allclose((left, jerk, gained), one, rtol=1e-9)


@pytest.mark.parametrize("jump", [0.0, 0.14, 0.3])
def test_a_jump_of_the_clock_while_a_vehicle_turns_its_tilt_is_taken_for_no_trim(jump: float) -> None:
    """The last command counts for the whole jump, for want of better knowledge, and passed in a tick."""
    plant, block = LostVehicle(np.zeros(3), 0.0, np.zeros(3)), DeadReckonedBraking(HOVER)
    for k in range(150):
        now = k * TICK + (jump if k >= 60 else 0.0)
        state = state_at(now, plant.vel[:2])
        state.pos[0], state.vel[0] = plant.pos, plant.vel
        lean = 0.25 if k < 50 else -0.25
        block.advance(state, None, now)
        block.record_nominal(state, level_at(now, CommandStatus.OK, roll=lean))
        plant.tick(level_at(now, CommandStatus.OK, roll=lean))
    for k in range(150, 250):  # lost, and told to be level: its trim moves what is reckoned
        now = k * TICK + jump
        block.advance(state_at(now, np.zeros(2), age=now), None, now)
        block.record_nominal(state_at(now, np.zeros(2)), level_at(now, CommandStatus.OK))
        plant.tick(level_at(now, CommandStatus.OK))
    reckoned = block.predicted(state_at(now, np.zeros(2), age=now)).vel[0]
    np.testing.assert_allclose(reckoned, plant.vel, atol=0.06)
