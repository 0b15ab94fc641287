"""Unobserved vehicles lose their last speed; observed ones and those level at rest are left alone."""

from dataclasses import replace

import numpy as np
import pytest
from reckoned_flights import HOVER, NAMES, TICK, UP, LostVehicle, flown, level_at, state_at, ticked

from q2q_control.failsafe.tracking_loss.braking_law import (
    BRAKING_MAX,
    BRAKING_S,
    SINK_MAX,
    TOUCHDOWN_MAX,
    ReckonedMotions,
    resting_places,
)
from q2q_control.failsafe.tracking_loss.dead_reckoned_braking import DeadReckonedBraking
from q2q_control.failsafe.tracking_loss.dead_reckoning import (
    LAG_S,
    POS,
    THRUST_LAG_S,
    TRACK_WIDTH,
    VEL,
)
from q2q_control.pid.pid_params import PidParams
from q2q_model.geometry.rotations import quat_from_euler, rotate
from q2q_model.signals.values import CommandStatus, Interference, SwarmCommand, TrackStatus
from q2q_model.vehicle.constants import GRAVITY


def flown_unmeasured(
    vel: np.ndarray, yaw: float, status: CommandStatus
) -> tuple[np.ndarray, list[SwarmCommand]]:
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
    vel, made = flown_unmeasured(np.array([0.8, -0.6]), yaw, status)
    # V: exp(-3 s / 0.5 s) of 1 m/s, and as much again for the largest deceleration; v = V (1 + L / tau)
    assert np.linalg.norm(vel) < 2.0 * np.exp(-6.0) * (1.0 + LAG_S / BRAKING_S)
    decelerations = [GRAVITY * np.hypot(np.tan(one.roll[0]), np.tan(one.pitch[0])) for one in made]
    assert max(decelerations) <= BRAKING_MAX * (1.0 + 1e-9)
    for command in made:
        assert (command.roll[1], command.pitch[1]) == (0.0, 0.0)  # its neighbour is seen
        assert command.thrust[1] == HOVER
        upright = np.cos(command.roll[0]) * np.cos(command.pitch[0])
        assert command.thrust[0] * upright == pytest.approx(HOVER, rel=0.03)  # the lag of the thrust


def test_vehicles_rest_where_the_largest_deceleration_and_then_a_decay_bring_them() -> None:
    """v^2 - v_1^2 = 2 a_max s down to v_1 = a_max tau, which decays within v_1 tau; the lag adds v L."""
    start, way = np.array([2.0, -1.0]), np.array([0.6, -0.8])
    track = np.zeros((2, TRACK_WIDTH))
    track[:, POS : POS + 2], track[:, POS + 2] = start, 1.3
    track[0, VEL : VEL + 2], track[1, VEL : VEL + 2] = 4.0 * way, -1.0 * way
    slow = BRAKING_MAX * BRAKING_S
    far = 4.0 * LAG_S + (4.0**2 - slow**2) / (2.0 * BRAKING_MAX) + slow * BRAKING_S
    rest = resting_places(ReckonedMotions(track, np.zeros((2, 3))))
    np.testing.assert_allclose(rest, [start + far * way, start - (LAG_S + BRAKING_S) * way], rtol=1e-12)


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


def test_the_largest_deceleration_asks_for_no_more_tilt_than_the_controllers() -> None:
    assert np.arctan(BRAKING_MAX / GRAVITY) <= PidParams().tilt_max


@pytest.mark.parametrize("vel", [1.2, -1.2])
def test_who_rises_or_sinks_when_it_is_lost_comes_to_rest(vel: float) -> None:
    plant = LostVehicle(np.array([0.0, 0.0, vel]), 0.0, np.zeros(3))
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
    assert pytest.approx(SINK_MAX - free * BRAKING_S, abs=0.01) == TOUCHDOWN_MAX  # rounded up


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
def test_below_another_the_trim_fades_whatever_of_it_is_predicted(share: float) -> None:
    """A downwash of 2 m/s^2, of which a share is predicted: all of the lift against it is given up."""
    block, plant = DeadReckonedBraking(HOVER), LostVehicle(np.zeros(3), 0.0, np.array([0.0, 0.0, -2.0]))
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
