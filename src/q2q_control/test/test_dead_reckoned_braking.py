"""Unobserved vehicles lose their last speed; observed ones and those level at rest are left alone."""

from dataclasses import replace

import numpy as np
import pytest

from q2q_control.failsafe.dead_reckoned_braking import BRAKING_MAX, DeadReckonedBraking
from q2q_control.failsafe.dead_reckoning import BALANCE_S, LAG_S, THRUST_LAG_S
from q2q_control.pid.pid import PidParams
from q2q_model.geometry.rotations import quat_from_euler, rotate
from q2q_model.signals.values import CommandStatus, SwarmCommand, SwarmState, TrackStatus
from q2q_model.vehicle.constants import GRAVITY

NAMES = ("cf1", "cf2")
UP = np.array([0.0, 0.0, 1.0])
TICK = 0.01
HOVER = 0.3
NONE = np.zeros(2)
"""Balances of vehicles that hover in still air."""


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


def flown_blind(vel: np.ndarray, yaw: float, status: CommandStatus) -> tuple[np.ndarray, list[SwarmCommand]]:
    """Return the velocity of the first vehicle, 3 s after it was last seen, and its commands.

    Its body's z axis follows the command with a first-order lag; nothing else moves it.
    """
    block, made = DeadReckonedBraking(HOVER), []
    block.record_measured(state_at(0.0, vel, yaw), level_at(0.0, CommandStatus.OK), NONE)
    tilt = np.zeros(2)
    for k in range(1, 300):
        t = k * TICK
        made.append(block.update(state_at(t, np.zeros(2), age=t), level_at(t, status), NONE))
        tilt += TICK / LAG_S * (np.array([made[-1].roll[0], made[-1].pitch[0]]) - tilt)
        vel = vel + GRAVITY * TICK * rotate(quat_from_euler(tilt[0], tilt[1], yaw), UP)[:2]
    return vel, made


@pytest.mark.parametrize("yaw", [0.0, 0.7, -2.5])
@pytest.mark.parametrize("status", [CommandStatus.LEVEL, CommandStatus.LAND])
def test_who_is_not_seen_comes_to_rest_whatever_its_heading(yaw: float, status: CommandStatus) -> None:
    vel, made = flown_blind(np.array([0.8, -0.6]), yaw, status)
    # exp(-3 s / 0.5 s) of 1 m/s, and as much again for the largest deceleration at first
    assert np.linalg.norm(vel) < 2.0 * np.exp(-6.0)
    decelerations = [GRAVITY * np.hypot(np.tan(one.roll[0]), np.tan(one.pitch[0])) for one in made]
    assert max(decelerations) <= BRAKING_MAX * (1.0 + 1e-9)
    for command in made:
        assert (command.roll[1], command.pitch[1]) == (0.0, 0.0)  # its neighbour is seen
        assert command.thrust[1] == HOVER
        upright = np.cos(command.roll[0]) * np.cos(command.pitch[0])
        assert command.thrust[0] * upright == pytest.approx(HOVER, rel=0.03)  # the lag of the thrust


def test_a_tilt_that_was_on_its_way_when_a_vehicle_was_lost_counts() -> None:
    block = DeadReckonedBraking(HOVER)
    leaning = quat_from_euler(np.full(2, -0.2), np.zeros(2), np.zeros(2))
    seen = replace(state_at(0.0, np.zeros(2)), quat=leaning)
    block.record_measured(seen, level_at(0.0, CommandStatus.OK, roll=-0.2), NONE)
    output = block.update(state_at(TICK, np.zeros(2), age=TICK), level_at(TICK), NONE)
    coming = GRAVITY * np.sin(0.2) * (LAG_S + TICK)  # m/s along y: a roll to the left
    assert output.roll[0] == pytest.approx(np.arctan(coming / 0.5 / GRAVITY), rel=1e-9)
    assert output.pitch[0] == 0.0


def test_commands_that_are_computed_or_held_are_left_alone() -> None:
    block = DeadReckonedBraking(HOVER)
    fast = np.array([1.0, 0.0])
    block.record_measured(state_at(0.0, fast), level_at(0.0, CommandStatus.OK), NONE)
    for status in (CommandStatus.DEGRADED, CommandStatus.HOLD, CommandStatus.CUT):
        given = level_at(TICK, status)
        assert block.update(state_at(TICK, fast, age=TICK), given, NONE) is given
    seen = replace(level_at(2.0 * TICK), status=np.full(2, CommandStatus.LEVEL, dtype=np.uint8))
    assert block.update(state_at(2.0 * TICK, fast), seen, NONE) is seen


def test_a_vehicle_that_was_never_seen_stays_level() -> None:
    block = DeadReckonedBraking(HOVER)
    for k in range(3):
        state = replace(state_at(k * TICK, np.zeros(2)), age=np.full(2, np.inf))
        output = block.update(state, level_at(k * TICK), NONE)
        np.testing.assert_array_equal(output.roll, 0.0)
        np.testing.assert_array_equal(output.pitch, 0.0)


@pytest.mark.parametrize("yaw", [0.0, 0.7, -2.5])
@pytest.mark.parametrize("roll", [0.0, 0.3])
def test_where_who_is_not_seen_comes_to_rest_is_known(yaw: float, roll: float) -> None:
    """The plant: thrust of the weight along a body axis that follows the commanded one with a lag."""
    block = DeadReckonedBraking(HOVER)
    pos, vel = np.zeros(2), np.array([0.8, -0.6])
    leaning = quat_from_euler(np.full(2, roll), np.zeros(2), np.full(2, yaw))
    up = rotate(leaning[0], UP)
    made = level_at(0.0, CommandStatus.OK, roll=roll)
    made = replace(made, thrust=made.thrust / np.cos(roll))
    block.record_measured(replace(state_at(0.0, vel, yaw), quat=leaning), made, NONE)
    rests = []
    for k in range(1, 300):
        t = k * TICK
        for _ in range(10):
            asked = rotate(quat_from_euler(made.roll[0], made.pitch[0], yaw), UP)
            up = up + 0.1 * TICK / LAG_S * (asked - up)
            vel = vel + 0.1 * TICK * GRAVITY * up[:2]
            pos = pos + 0.1 * TICK * vel
        unseen = state_at(t, np.zeros(2), age=t)
        known = block.predicted(unseen)
        # the plant's steps of 1 ms; heights by thrust that lags less than the tilt
        np.testing.assert_allclose(known.pos[0], [*pos, 0.0], atol=0.01)
        np.testing.assert_allclose(known.vel[0], [*vel, 0.0], atol=0.01)
        np.testing.assert_array_equal(known.pos[1], unseen.pos[1])  # its neighbour is seen
        made = block.update(unseen, level_at(t, CommandStatus.LEVEL), NONE)
        rests.append(block.reckoned(("cf1",))["cf1"].rest)
    assert np.linalg.norm(pos) > 0.4
    # a tilt of 0.3 rad takes the lag to end, and is counted as a velocity at once
    np.testing.assert_allclose(rests[0], pos, atol=0.05 if roll == 0.0 else 0.15)
    np.testing.assert_allclose(rests[30], pos, atol=0.05)
    np.testing.assert_allclose(vel, 0.0, atol=0.01)


def test_a_vehicle_that_was_never_seen_is_predicted_where_its_state_is() -> None:
    block, state = DeadReckonedBraking(HOVER), replace(state_at(0.0, np.ones(2)), age=np.full(2, 0.2))
    assert block.predicted(state) is state


def test_the_largest_deceleration_asks_for_no_more_tilt_than_the_controllers() -> None:
    assert np.arctan(BRAKING_MAX / GRAVITY) <= PidParams().tilt_max


def test_in_a_gap_between_ticks_a_tilt_is_taken_as_flown_for_a_tenth_of_a_second_at_most() -> None:
    def reckoned(gap: float) -> np.ndarray:
        block, leaning = DeadReckonedBraking(HOVER), level_at(0.0, CommandStatus.OK, roll=0.2)
        block.record_measured(state_at(0.0, np.array([1.0, 0.0])), leaning, NONE)
        block.update(state_at(gap, np.zeros(2), age=gap), level_at(gap, CommandStatus.HOLD, roll=0.2), NONE)
        return block.reckoned(("cf1",))["cf1"].pos

    assert reckoned(0.05)[0] == pytest.approx(0.05)
    np.testing.assert_array_equal(reckoned(0.1), reckoned(2.0))


def heights(vel: float, wash: float, balance: float, status: CommandStatus) -> np.ndarray:
    """Return height [m] and vertical velocity [m/s] of the first vehicle, 1 s from its last sight, (100, 2).

    A downwash pushes it by `wash` [m/s^2]; its thrust follows the command with a first-order lag.
    """
    block, both = DeadReckonedBraking(HOVER), np.full(2, balance)
    rising, made = state_at(0.0, np.zeros(2)), level_at(0.0, CommandStatus.OK)
    rising.vel[:, 2] = vel
    made = replace(made, thrust=np.full(2, HOVER * (1.0 + balance / GRAVITY)))
    block.record_measured(rising, made, both)
    height, thrust, flown = 0.0, made.thrust[0], []
    for k in range(1, 101):
        given = replace(level_at(k * TICK, status), thrust=np.full(2, SHARE[status] * HOVER))
        made = block.update(state_at(k * TICK, np.zeros(2), age=k * TICK), given, both)
        thrust += TICK / THRUST_LAG_S * (made.thrust[0] - thrust)
        vel += TICK * (GRAVITY * (thrust / HOVER - 1.0) + wash)
        height += TICK * vel
        flown.append((height, vel))
    return np.array(flown)


SHARE = {CommandStatus.LEVEL: 1.0, CommandStatus.LAND: 0.94}
"""Share of the hover thrust in the fallback's command."""


@pytest.mark.parametrize("vel", [1.2, -1.2])
def test_who_rises_or_sinks_when_it_is_lost_comes_to_rest(vel: float) -> None:
    flown = heights(vel, 0.0, 0.0, CommandStatus.LEVEL)
    # exp(-1 s / 0.5 s), and as much again for the largest lift and the lag of the thrust
    assert abs(flown[-1, 1]) < 2.0 * np.exp(-2.0) * abs(vel)
    assert abs(flown[-1, 0]) < abs(vel) * (0.5 + 0.15)


def test_who_lands_is_kept_from_rising_but_not_from_sinking() -> None:
    free = -0.06 * GRAVITY  # of 0.94 of the hover thrust
    assert heights(1.2, 0.0, 0.0, CommandStatus.LAND)[-1, 1] < 0.0
    sinking = heights(0.0, 0.0, 0.0, CommandStatus.LAND)
    assert sinking[-1, 1] == pytest.approx(free * (1.0 - THRUST_LAG_S), rel=0.05)


def test_a_downwash_that_was_balanced_is_so_at_first_and_then_forgotten() -> None:
    """In closed form: what a lift of b e^(-t/B) gains through the lag of the thrust."""
    known, unknown = (heights(0.0, -1.5, one, CommandStatus.LEVEL)[-1, 0] for one in (1.5, 0.0))
    parts = [tau**2 - tau**3 * (1.0 - np.exp(-1.0 / tau)) for tau in (BALANCE_S, THRUST_LAG_S)]
    gained = 1.5 * (parts[0] - parts[1]) / (BALANCE_S - THRUST_LAG_S)
    assert unknown == pytest.approx(-0.5 * 1.5, rel=0.02)
    assert known - unknown == pytest.approx(gained, rel=0.03)
