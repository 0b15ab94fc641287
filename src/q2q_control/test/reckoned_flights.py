"""Two vehicles of which the first is lost: states, commands and flights for tests of dead reckoning."""

from dataclasses import replace

import numpy as np
from resting_signals import level_command

from q2q_control.failsafe.tracking_loss.dead_reckoned_braking import DeadReckonedBraking
from q2q_control.failsafe.tracking_loss.dead_reckoning import (
    LAG_S,
    THRUST_LAG_S,
    TILT_SQUARE,
)
from q2q_model.geometry.rotations import quat_from_euler, rotate
from q2q_model.signals.values import CommandStatus, SwarmCommand, SwarmState, TrackStatus
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
    statuses = np.array([status, CommandStatus.OK], dtype=np.uint8)
    return level_command(t, NAMES, np.full(2, HOVER), roll=np.full(2, roll), status=statuses)


def ticked(block: DeadReckonedBraking, state: SwarmState, command: SwarmCommand) -> SwarmCommand:
    """Return the command of a tick without a prediction of downwash."""
    block.advance(state, None, state.t)
    return block.update(state, command)


class LostVehicle:
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


def flown(plant: LostVehicle, wanted: np.ndarray, steps: tuple[int, int]) -> np.ndarray:
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
