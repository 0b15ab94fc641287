"""Two vehicles under a guard: states, setpoints and controllers for tests of the failsafe."""

import numpy as np
from resting_signals import level_command, resting_setpoint, resting_state

from q2q_control.controller import Controller
from q2q_control.failsafe.fallback_params import FallbackParams
from q2q_control.failsafe.guard import Guard
from q2q_control.mpc.mpc import Mpc
from q2q_control.mpc.problem.mpc_params import MpcParams
from q2q_control.pid.pid import Pid
from q2q_control.pid.pid_params import PidParams
from q2q_model.downwash.no_interaction import NoInteraction
from q2q_model.signals.values import (
    CommandStatus,
    Names,
    SwarmCommand,
    SwarmSetpoint,
    SwarmState,
    TrackStatus,
)
from q2q_model.vehicle.constants import CRAZYFLIE_2_0

HOVER = CRAZYFLIE_2_0.hover_thrust
TICK = 0.01
NAMES = ("cf1", "cf2")
PARAMS = FallbackParams()
OK, SATURATED, HOLD, LEVEL, DEGRADED, LAND, CUT = (int(CommandStatus[name]) for name in (
    "OK", "SATURATED", "HOLD", "LEVEL", "DEGRADED", "LAND", "CUT"
))  # fmt: skip


def state_at(t: float, ages: tuple[float, ...] = (0.0, 0.0), coast: float = 0.35) -> SwarmState:
    """Return two hovering vehicles, measured `ages` ago; lost beyond `coast`, as the filter has it."""
    age = np.array(ages)
    late = np.where(age <= coast, TrackStatus.COASTING, TrackStatus.LOST)
    return resting_state(
        t,
        NAMES,
        np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 1.5]]),
        age=age,
        status=np.where(age == 0.0, TrackStatus.TRACKED, late).astype(np.uint8),
    )


def setpoint_at(t: float, names: Names = NAMES, x: float = 0.1) -> SwarmSetpoint:
    count = len(names)
    pos = np.array([[x, 0.0, 1.0], [1.0, 0.0, 1.5]])[:count]
    return resting_setpoint(t, names, pos)


def pid() -> Pid:
    return Pid(PidParams(), CRAZYFLIE_2_0)


def mpc() -> Mpc:
    return Mpc(MpcParams(), CRAZYFLIE_2_0, NoInteraction())


class Level:
    """Controller that always hovers level."""

    def update(self, _: SwarmState, setpoint: SwarmSetpoint, __: object) -> SwarmCommand:
        """Return level hover."""
        status = np.full(2, OK, dtype=np.uint8)
        return level_command(setpoint.t, NAMES, np.full(2, HOVER), status=status)

    def reset(self) -> None:
        """Do nothing."""


class Scripted:
    """Controller of as many vehicles as it has statuses, which keeps the setpoints that it was given."""

    def __init__(self, *status: int) -> None:
        self.status, self.given = status, list[SwarmSetpoint]()

    def update(self, _: SwarmState, setpoint: SwarmSetpoint, __: object) -> SwarmCommand:
        """Return level hover under these statuses."""
        self.given.append(setpoint)
        level, count = Level().update(_, setpoint, __), len(self.status)
        self.made = SwarmCommand(
            level.t,
            level.names[:count],
            level.thrust[:count],
            level.roll[:count],
            level.pitch[:count],
            level.yaw_rate[:count],
            np.array(self.status, dtype=np.uint8),
        )
        return self.made

    def reset(self) -> None:
        """Do nothing."""


def guarded(controller: Controller | None = None) -> Guard:
    return Guard(controller or pid(), PARAMS, HOVER)


def fly(guard: Guard, first: int, last: int, unseen_since: float | None = None) -> list[SwarmCommand]:
    """Answer ticks first to last, not seeing cf1 since a time [s]."""
    made = []
    for k in range(first, last):
        t = k * TICK
        age = 0.0 if unseen_since is None or t <= unseen_since else t - unseen_since
        made.append(guard.update(state_at(t, (age, 0.0)), setpoint_at(t), None))
    return made
