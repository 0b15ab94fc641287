"""Onboard planner: take-off, landing, go-to, spirals and uploaded trajectories.

Source: firmware: modules/src/planner.c, crtp_commander_high_level.c. Three states:

    IDLE -- take-off, go-to, trajectory --> FLYING -- land --> LANDING -- end of the polynomial --> IDLE
    FLYING, LANDING -- NaN goal --> DISABLED -- go-to, trajectory, land --> as from IDLE

IDLE commands motors off, DISABLED commands nothing: the last setpoint ages. A new piece starts from the
present goal, or, if there is none, from the estimated position. Yaw turns the shorter way (yaw_turn). A go-to
at constant speed in 0 s, or a trajectory with invalid numbers, has a NaN goal.
"""

from dataclasses import dataclass, replace
from enum import Enum, IntEnum, auto

import numpy as np

from q2q_model.signals.values import Array
from q2q_sim.firmware.commander.piecewise import Piecewise
from q2q_sim.firmware.commander.polynomial import Goal, Piece, goal_at_rest, piece_between
from q2q_sim.firmware.commander.yaw_turn import shortest_turn, wrap_yaw


class PlanState(IntEnum):
    """States of the planner."""

    IDLE = 0
    FLYING = 1
    LANDING = 3
    DISABLED = 4


MOVING = (PlanState.FLYING, PlanState.LANDING)
"""A trajectory is being flown."""


class Begin(Enum):
    """Where a trajectory begins."""

    AS_WRITTEN = auto()
    HERE = auto()
    """At the present position."""
    HERE_TURNED = auto()
    """At the present position, rotated to the present yaw."""


class PlannerResult(IntEnum):
    """Result of a command; values as errno on the wire."""

    OK = 0
    WRONG_STATE = 1
    UNKNOWN = 8
    """ENOEXEC."""
    BLOCKED = 16
    """EBUSY: the supervisor does not permit flight."""


@dataclass(frozen=True, slots=True)
class Target:
    """End point of a go-to."""

    pos: tuple[float, float, float]
    """[m], world."""
    yaw: float
    """[rad]"""
    duration: float
    """[s]"""
    relative: bool = False
    """Position and yaw are relative to the present goal."""
    linear: bool = False
    """Constant speed instead of rest to rest; NaN for 0 s."""


@dataclass(frozen=True, slots=True)
class Vertical:
    """End of a take-off or landing."""

    height: float
    """[m], world."""
    duration: float
    """[s]"""
    yaw: float | None = None
    """[rad]; None keeps the present one."""


class Planner:
    """Planner with the trajectory being flown."""

    def __init__(self) -> None:
        self.state = PlanState.IDLE
        self._trajectory: Piecewise | None = None
        self._here = goal_at_rest(np.zeros(3), 0.0)

    def set_state(self, pos: Array, vel: Array, yaw: float) -> None:
        """Set the estimate from which plans start when idle: [m], [m/s], world, (3,), and yaw [rad]."""
        self._here = Goal(pos, vel, np.zeros(3), yaw, np.zeros(3))

    def finished(self, t: float) -> bool:
        """Return whether no trajectory is being flown at time t [s]."""
        one = self._trajectory
        return one is None or t - one.begin >= one.duration

    def goal(self, t: float) -> Goal | None:
        """Return the goal at time t [s]; None if there is none."""
        if self.state == PlanState.LANDING and self.finished(t):
            self.state = PlanState.IDLE
        if self.state not in MOVING or self._trajectory is None:
            return None
        goal = self._trajectory.goal(t)
        if not np.isfinite(goal.pos).all():
            self.state = PlanState.DISABLED
            return None
        self._here = goal
        return goal

    def stop(self) -> PlannerResult:
        """Drop the trajectory: motors off."""
        self.state = PlanState.IDLE
        return PlannerResult.OK

    def take_off(self, end: Vertical, t: float) -> PlannerResult:
        """Take off at once, if idle."""
        if self.state != PlanState.IDLE:
            return PlannerResult.WRONG_STATE
        return self._vertical(end, t, PlanState.FLYING)

    def land(self, end: Vertical, t: float) -> PlannerResult:
        """Land at once, unless landing already; the motors stop at the end."""
        if self.state == PlanState.LANDING:
            return PlannerResult.WRONG_STATE
        return self._vertical(end, t, PlanState.LANDING)

    @np.errstate(all="ignore")
    def go_to(self, target: Target, t: float) -> PlannerResult:
        """Fly to a target at once."""
        start = self._now(t)
        pos, yaw = np.array(target.pos), target.yaw
        if target.relative:
            pos, yaw = pos + start.pos, float(np.float32(yaw) + np.float32(start.yaw))
        start_yaw = wrap_yaw(start.yaw)
        turn = shortest_turn(start_yaw, wrap_yaw(yaw))
        begin = replace(start, yaw=start_yaw)
        end = goal_at_rest(pos, start_yaw + turn)
        if target.linear:
            duration = np.float64(target.duration)
            vel, rates = (pos - start.pos) / duration, np.array([0.0, 0.0, turn]) / duration
            begin = Goal(start.pos, vel, np.zeros(3), start_yaw, rates)
            end = Goal(pos, vel, np.zeros(3), start_yaw + turn, rates)
        return self._fly(piece_between(begin, end, target.duration), t, PlanState.FLYING)

    @np.errstate(all="ignore")
    def follow(self, trajectory: Piecewise, begin: Begin) -> PlannerResult:
        """Fly a trajectory.

        As in the firmware, the rotation is about the world's origin and does not apply to the shift: a
        rotated trajectory starts here only if its first point is the origin.
        """
        self._trajectory = trajectory
        if begin is not Begin.AS_WRITTEN:
            first = trajectory.goal(trajectory.begin)
            x, y, z = (self._here.pos - first.pos).tolist()
            turned = begin is Begin.HERE_TURNED
            turn = shortest_turn(wrap_yaw(first.yaw), wrap_yaw(self._here.yaw)) if turned else 0.0
            self._trajectory = replace(trajectory, shift=(x, y, z), turn=turn)
        self.state = PlanState.FLYING
        return PlannerResult.OK

    def fly_piece(self, piece: Piece, t: float) -> PlannerResult:
        """Fly one piece at once."""
        return self._fly(piece, t, PlanState.FLYING)

    @property
    def trajectory(self) -> Piecewise | None:
        """Return the last trajectory that was begun; None if there is none."""
        return self._trajectory

    @property
    def here(self) -> Goal:
        """Return the last goal, or the estimated position when idle."""
        return self._here

    def _now(self, t: float) -> Goal:
        if self.state in MOVING and self._trajectory is not None:
            return self._trajectory.goal(t)
        return replace(self._here, acc=np.zeros(3), ang_vel_body=np.zeros(3))

    def _vertical(self, end: Vertical, t: float, state: PlanState) -> PlannerResult:
        pos, yaw = self._here.pos, wrap_yaw(self._here.yaw)
        top = np.array([pos[0], pos[1], end.height])
        turn = shortest_turn(yaw, wrap_yaw(self._here.yaw if end.yaw is None else end.yaw))
        piece = piece_between(goal_at_rest(pos, yaw), goal_at_rest(top, yaw + turn), end.duration)
        return self._fly(piece, t, state)

    def _fly(self, piece: Piece, t: float, state: PlanState) -> PlannerResult:
        self._trajectory = Piecewise((piece,), t)
        self.state = state
        return PlannerResult.OK
