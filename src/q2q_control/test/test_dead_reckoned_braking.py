"""Unobserved vehicles lose their last speed; observed ones and those level at rest are left alone."""

from dataclasses import replace

import numpy as np
import pytest

from q2q_control.disturbance.thrust_acceleration import Command
from q2q_control.failsafe.blind_flight.braking_law import BRAKING_MAX, BRAKING_S, SINK_MAX
from q2q_control.failsafe.blind_flight.dead_reckoned_braking import DeadReckonedBraking
from q2q_control.failsafe.blind_flight.dead_reckoning import (
    BALANCE,
    BALANCE_MAX,
    LAG_S,
    THRUST_LAG_S,
    TILT_SQUARE,
    VEL,
    WIDTH,
    Sight,
    _tilted,
    reckon,
)
from q2q_control.pid.pid import PidParams
from q2q_model.estimation.mocap_filter import MocapFilterParams
from q2q_model.geometry.rotations import quat_from_euler, rotate
from q2q_model.signals.values import CommandStatus, Interference, SwarmCommand, SwarmState, TrackStatus
from q2q_model.vehicle.constants import GRAVITY

NAMES = ("cf1", "cf2")
UP = np.array([0.0, 0.0, 1.0])
TICK = 0.01
HOVER = 0.3
LEVEL = np.array([[0.0, 0.0, 0.0, 1.0]])


def state_at(t: float, vel: np.ndarray, yaw: float = 0.0, age: float = 0.0) -> SwarmState:
    """Return two vehicles at the same velocity (2,) and yaw, the first measured `age` ago."""
    return SwarmState(
        t=t,
        names=NAMES,
        pos=np.zeros((2, 3)),
        vel=np.tile([*vel, 0.0], (2, 1)),
        quat=quat_from_euler(np.zeros(2), np.zeros(2), np.full(2, yaw)),
        ang_vel_body=np.zeros((2, 3)),
        age=np.array([age, 0.0]),
        status=np.array(
            [TrackStatus.LOST if age else TrackStatus.TRACKED, TrackStatus.TRACKED], dtype=np.uint8
        ),
    )


def level_at(t: float, status: CommandStatus = CommandStatus.LEVEL, roll: float = 0.0) -> SwarmCommand:
    zero = np.zeros(2)
    statuses = np.array([status, CommandStatus.OK], dtype=np.uint8)
    return SwarmCommand(t, NAMES, np.full(2, HOVER), np.full(2, roll), zero, zero, statuses)


def test_a_weak_vehicle_gains_as_much_by_its_tilt_as_its_thrust_holds() -> None:
    """With 1.2 m/s^2 to balance, a thrust that holds the weight accelerates by g tan(tilt), as without."""
    for weak in (0.0, 1.2):
        track = np.zeros((1, WIDTH))
        track[0, BALANCE + 2] = weak
        share = (1.0 + weak / GRAVITY) / np.cos(0.2)
        asked = Command(np.array([share * HOVER]), np.zeros(1), np.array([0.2]))
        unseen = Sight(
            np.zeros((1, 3)), np.zeros((1, 3)), LEVEL, np.array([TrackStatus.LOST], dtype=np.uint8)
        )
        for _ in range(300):
            before = track[0, VEL]
            reckon(track, asked, np.zeros((1, 3)), (TICK, HOVER), unseen)
        assert (track[0, VEL] - before) / TICK == pytest.approx(GRAVITY * np.tan(0.2), rel=1e-4)
        assert track[0, VEL + 2] == pytest.approx(0.0, abs=1e-9 if not weak else 0.2)


def ticked(block: DeadReckonedBraking, state: SwarmState, command: SwarmCommand) -> SwarmCommand:
    """Return the command of a tick without a prediction of downwash."""
    block.advance(state, None, state.t)
    return block.update(state, command)


def flown_blind(vel: np.ndarray, yaw: float, status: CommandStatus) -> tuple[np.ndarray, list[SwarmCommand]]:
    """Return the velocity of the first vehicle, 3 s after it was last seen, and its commands.

    Its body's z axis follows the command with a first-order lag; nothing else moves it.
    """
    block, made = DeadReckonedBraking(HOVER), []
    block.update(state_at(0.0, vel, yaw), level_at(0.0, CommandStatus.OK))
    tilt = np.zeros(2)
    for k in range(1, 300):
        t = k * TICK
        made.append(ticked(block, state_at(t, np.zeros(2), age=t), level_at(t, status)))
        tilt += TICK / LAG_S * (np.array([made[-1].roll[0], made[-1].pitch[0]]) - tilt)
        up = rotate(quat_from_euler(tilt[0], tilt[1], yaw), UP)
        vel = vel + GRAVITY * TICK * up[:2] / up[2]  # its thrust carries it
    return vel, made


@pytest.mark.parametrize("yaw", [0.0, 0.7, -2.5])
@pytest.mark.parametrize("status", [CommandStatus.LEVEL, CommandStatus.LAND])
def test_who_is_not_seen_comes_to_rest_whatever_its_heading(yaw: float, status: CommandStatus) -> None:
    vel, made = flown_blind(np.array([0.8, -0.6]), yaw, status)
    # V: exp(-3 s / 0.5 s) of 1 m/s, and as much again for the largest deceleration; v = V (1 + L / tau)
    assert np.linalg.norm(vel) < 2.0 * np.exp(-6.0) * (1.0 + LAG_S / BRAKING_S)
    decelerations = [GRAVITY * np.hypot(np.tan(one.roll[0]), np.tan(one.pitch[0])) for one in made]
    assert max(decelerations) <= BRAKING_MAX * (1.0 + 1e-9)
    for command in made:
        assert (command.roll[1], command.pitch[1]) == (0.0, 0.0)  # its neighbour is seen
        assert command.thrust[1] == HOVER
        upright = np.cos(command.roll[0]) * np.cos(command.pitch[0])
        assert command.thrust[0] * upright == pytest.approx(HOVER, rel=0.03)  # the lag of the thrust


def test_a_command_that_was_held_through_a_gap_counts_for_all_of_it() -> None:
    """Frames stopped for 0.25 s while a vehicle leaned: it is reckoned as one of which every tick came."""
    speeds = []
    for gap in (TICK, 0.25):
        block = DeadReckonedBraking(HOVER)
        block.update(state_at(0.0, np.zeros(2)), level_at(0.0, CommandStatus.OK, roll=0.3))
        for k in range(1, round(0.5 / gap) + 1):
            t = k * gap
            block.advance(state_at(t, np.zeros(2), age=t), None, t)
            block.record_nominal(state_at(t, np.zeros(2)), level_at(t, CommandStatus.OK, roll=0.3))
        speeds.append(block.predicted(state_at(0.5, np.zeros(2), age=0.5)).vel[0, 1])
    assert speeds[0] == pytest.approx(-GRAVITY * np.sin(0.3) * (0.5 - LAG_S), rel=0.1)
    assert speeds[1] == pytest.approx(speeds[0], rel=1e-9)


def test_commands_that_are_computed_or_held_are_left_alone() -> None:
    block = DeadReckonedBraking(HOVER)
    fast = np.array([1.0, 0.0])
    block.update(state_at(0.0, fast), level_at(0.0, CommandStatus.OK))
    for status in (CommandStatus.DEGRADED, CommandStatus.HOLD, CommandStatus.CUT):
        given = level_at(TICK, status)
        assert ticked(block, state_at(TICK, fast, age=TICK), given) is given
    seen = replace(level_at(2.0 * TICK), status=np.full(2, CommandStatus.LEVEL, dtype=np.uint8))
    assert ticked(block, state_at(2.0 * TICK, fast), seen) is seen


def test_a_vehicle_that_was_never_seen_stays_level() -> None:
    block = DeadReckonedBraking(HOVER)
    for k in range(3):
        state = replace(
            state_at(k * TICK, np.zeros(2), age=1.0), status=np.full(2, TrackStatus.LOST, dtype=np.uint8)
        )
        output = ticked(block, state, level_at(k * TICK))
        np.testing.assert_array_equal(output.roll, 0.0)
        np.testing.assert_array_equal(output.pitch, 0.0)
        np.testing.assert_array_equal(output.thrust, HOVER)
        assert block.predicted(state) is state


class Flown:
    """The plant: a body's z axis that follows commands as a second order, a thrust as a first, and a push."""

    def __init__(self, vel: np.ndarray, yaw: float, push: np.ndarray, offset: float = 0.0) -> None:
        self.pos, self.vel, self.up, self.lift = np.zeros(3), vel.copy(), UP.copy(), 0.0
        self.turning = np.zeros(2)
        self.yaw, self.push, self.offset = yaw, push, offset

    def tick(self, command: SwarmCommand) -> None:
        """Fly the first vehicle of a command for a tick; its roll is off by `offset` [rad]."""
        roll, pitch = command.roll[0] + self.offset, command.pitch[0]
        asked = rotate(quat_from_euler(roll, pitch, self.yaw), UP)
        for _ in range(10):
            self.turning += 0.1 * TICK * TILT_SQUARE * (asked[:2] - self.up[:2] - LAG_S * self.turning)
            self.up[:2] += 0.1 * TICK * self.turning
            lift = GRAVITY * (command.thrust[0] * asked[2] / HOVER - 1.0)
            self.lift += 0.1 * TICK / THRUST_LAG_S * (lift - self.lift)
            acc = np.array([*((GRAVITY + self.lift) * self.up[:2]), self.lift])
            self.vel += 0.1 * TICK * (acc + self.push)
            self.pos += 0.1 * TICK * self.vel


def flown(plant: Flown, wanted: np.ndarray, steps: tuple[int, int]) -> np.ndarray:
    """Return positions, velocities and what is reckoned of them after the last sight, (steps[1], 12).

    For steps[0] ticks the vehicle is seen, and its commands ask for the accelerations of `wanted` (n, 3) in
    turn, in its own frame; then it is not seen for steps[1] ticks, and level.
    """
    block, found = DeadReckonedBraking(HOVER), []
    for k in range(sum(steps)):
        seen = k < steps[0]
        state = state_at(k * TICK, plant.vel[:2], plant.yaw, age=0.0 if seen else k * TICK)
        state.pos[0], state.vel[0] = (plant.pos, plant.vel) if seen else (0.0, 0.0)
        state.pos[1] = [5.0, 5.0, 0.0]  # nobody is above
        block.advance(state, None, state.t)
        if not seen:
            known = block.predicted(state)
            found.append(np.concatenate((plant.pos, plant.vel, known.pos[0], known.vel[0])))
        given = level_at(k * TICK, CommandStatus.OK if seen else CommandStatus.LEVEL)
        if seen:
            ahead, aside, up = wanted[k % len(wanted)]
            share = 1.0 + up / GRAVITY
            given = replace(
                given,
                thrust=np.full(2, HOVER * share),
                roll=np.full(2, -aside / GRAVITY / share),
                pitch=np.full(2, ahead / GRAVITY / share),
            )
        plant.tick(block.update(state, given))
    return np.array(found)


@pytest.mark.parametrize("yaw", [0.0, 0.7, -2.5])
@pytest.mark.parametrize("tilt", [0.0, 2.0])
def test_where_who_is_not_seen_is_and_that_it_comes_to_rest_is_known(yaw: float, tilt: float) -> None:
    plant = Flown(np.array([0.4, -0.3, 0.0]), yaw, np.zeros(3))
    found = flown(plant, np.array([[tilt, 0.0, 0.0]]), (20, 280))
    ways, reckoned = found[:, :6], found[:, 6:]
    # the plant's thrust tilts with its body, steps of 1 ms against ticks
    np.testing.assert_allclose(reckoned, ways, atol=0.03)
    assert np.linalg.norm(ways[-1, :2] - ways[0, :2]) > 0.15
    np.testing.assert_allclose(ways[-1, 3:], 0.0, atol=0.02)


WINDS = {"none": np.zeros(3), "wind": np.array([0.5, -0.3, 0.0]), "downwash": np.array([0.0, 0.0, -2.0])}


@pytest.mark.parametrize("push", WINDS.values(), ids=WINDS)
@pytest.mark.parametrize("offset", [0.0, 0.05], ids=["true", "trimmed"])
def test_what_was_balanced_is_balanced_without_measurements(push: np.ndarray, offset: float) -> None:
    """A steady push, and a vehicle that leans when it is told to be level."""
    plant = Flown(np.zeros(3), 0.4, push, offset)
    frame = np.array([[np.cos(0.4), np.sin(0.4), 0.0], [-np.sin(0.4), np.cos(0.4), 0.0], [0.0, 0.0, 1.0]])
    trim = np.array([0.0, (GRAVITY - push[2]) * np.sin(offset), 0.0])  # of the thrust that it flies at
    found = flown(plant, (trim - frame @ push)[None], (600, 100))
    unbalanced = np.linalg.norm(push + trim)  # [m/s], in a second
    assert np.linalg.norm(found[-1, 3:6]) < 0.03 + 0.03 * unbalanced
    np.testing.assert_allclose(found[:, 6:9], found[:, :3], atol=0.04)


def test_an_acceleration_that_is_wanted_is_no_balance() -> None:
    """To and fro, up and down: the vehicle does what it is told to."""
    plant = Flown(np.zeros(3), 0.0, np.zeros(3))
    wanted = np.repeat([[1.0, 0.0, 1.5], [-1.0, 0.0, -1.5], [-1.0, 0.0, -1.5], [1.0, 0.0, 1.5]], 20, axis=0)
    found = flown(plant, wanted, (340, 100))
    np.testing.assert_allclose(found[-1, 3:6], 0.0, atol=0.12)
    np.testing.assert_allclose(found[:, 6:9], found[:, :3], atol=0.05)


@pytest.mark.parametrize("share", [0.0, 2.0])
def test_no_more_is_balanced_than_a_vehicle_may_be_given(share: float) -> None:
    """A vehicle that does not move with its motors off, or at twice its weight: it is held."""
    track, sight = (
        np.zeros((1, WIDTH)),
        Sight(np.zeros((1, 3)), np.zeros((1, 3)), LEVEL, np.zeros(1, np.uint8)),
    )
    for _ in range(300):
        asked = Command(np.full(1, share * HOVER), np.zeros(1), np.zeros(1))
        reckon(track, asked, np.zeros((1, 3)), (TICK, HOVER), sight)
    assert track[0, BALANCE + 2] == np.sign(share - 1.0) * BALANCE_MAX[1]
    np.testing.assert_array_equal(track[0, BALANCE : BALANCE + 2], 0.0)


@pytest.mark.parametrize("speed", [3.0, 1e300, np.inf, np.nan])
def test_a_velocity_that_jumps_is_no_balance(speed: float) -> None:
    """A track that restarts, or a state that means nothing, for 0.1 s."""
    track, level = np.zeros((1, WIDTH)), Command(np.full(1, HOVER), np.zeros(1), np.zeros(1))
    for k in range(100):
        vel = np.full((1, 3), speed if 50 <= k < 60 else 0.0)
        sight = Sight(np.zeros((1, 3)), vel, LEVEL, np.zeros(1, np.uint8))
        reckon(track, level, np.zeros((1, 3)), (TICK, HOVER), sight)
    np.testing.assert_array_equal(track[0, VEL : VEL + 3], 0.0)
    np.testing.assert_array_equal(track[0, BALANCE : BALANCE + 3], 0.0)


def test_the_largest_deceleration_asks_for_no_more_tilt_than_the_controllers() -> None:
    assert np.arctan(BRAKING_MAX / GRAVITY) <= PidParams().tilt_max


def test_in_a_gap_between_ticks_a_tilt_is_taken_as_flown_for_as_long_as_a_vehicle_coasts_at_most() -> None:
    def reckoned(gap: float) -> np.ndarray:
        block, leaning = DeadReckonedBraking(HOVER), level_at(0.0, CommandStatus.OK, roll=0.2)
        block.update(state_at(0.0, np.array([1.0, 0.0])), leaning)
        lost = state_at(gap, np.zeros(2), age=gap)
        ticked(block, lost, level_at(gap, CommandStatus.HOLD, roll=0.2))
        return block.reckoned(("cf1",))["cf1"].pos

    assert reckoned(0.05)[0] == pytest.approx(0.05)
    np.testing.assert_array_equal(reckoned(MocapFilterParams().coast_s), reckoned(2.0))


@pytest.mark.parametrize("vel", [1.2, -1.2])
def test_who_rises_or_sinks_when_it_is_lost_comes_to_rest(vel: float) -> None:
    plant = Flown(np.array([0.0, 0.0, vel]), 0.0, np.zeros(3))
    found = flown(plant, np.zeros((1, 3)), (1, 101))
    # exp(-1 s / 0.5 s), and as much again for the largest lift and the lag of the thrust
    assert abs(found[-1][5]) < 2.0 * np.exp(-2.0) * abs(vel)
    assert abs(found[-1][2]) < abs(vel) * (0.5 + 0.15)


def test_who_lands_is_kept_from_rising_and_from_sinking_fast() -> None:
    def landed(vel: float, seconds: float) -> float:
        """Return the vertical velocity after a time of landing [m/s]."""
        block, thrust = DeadReckonedBraking(HOVER), 0.0
        for k in range(round(seconds / TICK) + 1):
            seen = k == 0
            state = state_at(k * TICK, np.zeros(2), age=k * TICK)
            state.vel[0, 2] = vel if seen else 0.0
            given = level_at(k * TICK, CommandStatus.OK if seen else CommandStatus.LAND)
            given = given if seen else replace(given, thrust=np.full(2, 0.94 * HOVER))
            lift = GRAVITY * (ticked(block, state, given).thrust[0] / HOVER - 1.0)
            thrust += TICK / THRUST_LAG_S * (lift - thrust)
            vel += TICK * thrust
        return vel

    free = -0.06 * GRAVITY  # of 0.94 of the hover thrust
    assert landed(1.2, 1.0) < 0.0
    assert landed(0.0, 1.0) == pytest.approx(free * (1.0 - THRUST_LAG_S), rel=0.05)
    for vel in (0.0, -2.0):  # exp(-4 s / 0.5 s) of what is beyond, and free fall from the height of 2 m
        assert landed(vel, 4.0) == pytest.approx(free * BRAKING_S - SINK_MAX, rel=0.03)


def test_a_downwash_fades_alike_after_the_clock_was_set_back() -> None:
    """The lower vehicle is lost under a predicted downwash."""

    def lift(set_back: float) -> float:
        """Return the thrust [N] half a second after the loss."""
        block = DeadReckonedBraking(HOVER)
        push = np.array([[0.0, 0.0, -2.0], [0.0, 0.0, 0.0]])
        eta = Interference(0.0, NAMES, push, np.zeros((2, 3)), np.zeros(2, np.uint8))
        for k in range(61):
            t = 5.0 + k * TICK - (set_back if k > 10 else 0.0)
            if k == 11:
                block.set_back(set_back)
            state = state_at(t, np.zeros(2), age=max(k - 9, 0) * TICK)
            state.pos[1] = [0.0, 0.0, 0.5]
            block.advance(state, replace(eta, t=t), t)
            command = block.update(state, level_at(t, CommandStatus.LEVEL if k > 9 else CommandStatus.OK))
        return float(command.thrust[0])

    assert lift(0.49) == pytest.approx(lift(0.0), rel=1e-9)
    assert HOVER < lift(0.0) < HOVER * (1.0 + 2.0 / GRAVITY)


@pytest.mark.parametrize("share", [0.0, 0.5, 1.0, 1.5])
def test_below_another_what_is_balanced_fades_whatever_of_it_is_predicted(share: float) -> None:
    """A downwash of 2 m/s^2, of which a share is predicted: all of the lift against it is given up."""
    block, plant = DeadReckonedBraking(HOVER), Flown(np.zeros(3), 0.0, np.array([0.0, 0.0, -2.0]))
    plant.lift = 2.0
    predicted = Interference(
        0.0, NAMES, np.array([share * plant.push, np.zeros(3)]), np.zeros((2, 3)), np.zeros(2, np.uint8)
    )
    lift = []
    for k in range(800):
        seen = k < 600
        state = state_at(k * TICK, plant.vel[:2], age=0.0 if seen else k * TICK)
        state.pos[0], state.vel[0] = (plant.pos, plant.vel) if seen else (0.0, 0.0)
        state.pos[1] = [0.0, 0.0, 0.5]
        block.advance(state, replace(predicted, t=state.t), state.t)
        given = level_at(k * TICK, CommandStatus.OK if seen else CommandStatus.LEVEL)
        if seen:
            given = replace(given, thrust=np.full(2, HOVER * (1.0 + 2.0 / GRAVITY)))
        command = block.update(state, given)
        plant.tick(command)
        lift.append(GRAVITY * (command.thrust[0] / HOVER - 1.0))
    assert lift[600] == pytest.approx(2.0, abs=0.1)
    assert lift[650] == pytest.approx(2.0 * np.exp(-1.0), abs=0.15)
    assert abs(lift[-1]) < 2.0 * np.exp(-4.0) + 0.1


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
