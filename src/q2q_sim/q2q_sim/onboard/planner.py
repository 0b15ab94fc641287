"""Plan take-off, landing, go-to, spirals and uploaded trajectories on board.

Source: firmware: modules/src/planner.c, crtp_commander_high_level.c. Three states:

    IDLE -- take-off, go-to, trajectory --> FLYING -- land --> LANDING -- end of the polynomial --> IDLE

IDLE asks for motors off. A new piece starts from the goal of the moment, or, when idle, from where the
vehicle believes to be. Yaw turns the shorter way. What a command may answer is in `Answer`.
"""

import math
from dataclasses import dataclass, replace
from enum import IntEnum

import numpy as np

from q2q_model.signals import Array
from q2q_sim.onboard.piecewise import Piecewise
from q2q_sim.onboard.polynomial import Goal, Piece, piece_between, resting


class PlanState(IntEnum):
    """Name what the planner does."""

    IDLE = 0
    FLYING = 1
    LANDING = 3


class Answer(IntEnum):
    """Say what became of a command; values as errno on the wire."""

    OK = 0
    WRONG_STATE = 1
    UNKNOWN = 8
    """ENOEXEC."""
    BLOCKED = 16
    """EBUSY: the supervisor does not let it fly."""


@dataclass(frozen=True, slots=True)
class Target:
    """Say where a go-to ends."""

    pos: tuple[float, float, float]
    """[m], world."""
    yaw: float
    """[rad]"""
    duration: float
    """[s]"""
    relative: bool = False
    """Position and yaw count from the goal of the moment."""
    linear: bool = False
    """Constant speed instead of rest to rest."""


@dataclass(frozen=True, slots=True)
class Vertical:
    """Say how a take-off or landing ends."""

    height: float
    """[m], world."""
    duration: float
    """[s]"""
    yaw: float | None = None
    """[rad]; None keeps the present one."""


class Planner:
    """Hold the trajectory under way."""

    def __init__(self) -> None:
        self.state = PlanState.IDLE
        self._trajectory: Piecewise | None = None
        self._here = resting(np.zeros(3), 0.0)

    def tell(self, pos: Array, vel: Array, yaw: float) -> None:
        """Note where the vehicle believes to be: new plans start there when idle."""
        self._here = Goal(pos, vel, np.zeros(3), yaw, np.zeros(3))

    def finished(self, t: float) -> bool:
        """Return whether no trajectory is under way at time t [s]."""
        one = self._trajectory
        return one is None or t - one.begin >= one.duration

    def goal(self, t: float) -> Goal | None:
        """Return the goal at time t [s]; None when idle."""
        if self.state == PlanState.LANDING and self.finished(t):
            self.state = PlanState.IDLE
        if self.state == PlanState.IDLE or self._trajectory is None:
            return None
        self._here = self._trajectory.goal(t)
        return self._here

    def stop(self) -> Answer:
        """Forget the trajectory: motors off."""
        self.state = PlanState.IDLE
        return Answer.OK

    def take_off(self, end: Vertical, t: float) -> Answer:
        """Rise at once, if idle."""
        if self.state != PlanState.IDLE:
            return Answer.WRONG_STATE
        return self._vertical(end, t, PlanState.FLYING)

    def land(self, end: Vertical, t: float) -> Answer:
        """Descend at once, if not landing; the motors stop at the end."""
        if self.state == PlanState.LANDING:
            return Answer.WRONG_STATE
        return self._vertical(end, t, PlanState.LANDING)

    def go_to(self, target: Target, t: float) -> Answer:
        """Fly to a target at once."""
        start = self._now(t)
        pos, yaw = np.array(target.pos), target.yaw
        if target.relative:
            pos, yaw = pos + start.pos, yaw + start.yaw
        goal_yaw = _nearest_yaw(start.yaw, yaw)
        start_yaw = _wrapped(start.yaw)
        begin = Goal(start.pos, start.vel, start.acc, start_yaw, start.ang_vel_body)
        end = resting(pos, goal_yaw)
        if target.linear and target.duration > 0.0:
            vel = (pos - start.pos) / target.duration
            rates = np.array([0.0, 0.0, (goal_yaw - start_yaw) / target.duration])
            begin = Goal(start.pos, vel, np.zeros(3), start_yaw, rates)
            end = Goal(pos, vel, np.zeros(3), goal_yaw, rates)
        return self._fly(piece_between(begin, end, target.duration), t, PlanState.FLYING)

    def follow(self, trajectory: Piecewise, *, from_here: bool, turned: bool) -> Answer:
        """Fly a trajectory; shifted so that it starts here, and turned so that its yaw does."""
        self._trajectory = trajectory
        if from_here:
            first = trajectory.goal(trajectory.begin)
            turn = _wrapped(self._here.yaw - first.yaw) if turned else 0.0
            about = replace(trajectory, turn=turn)
            x, y, z = (self._here.pos - about.goal(trajectory.begin).pos).tolist()
            self._trajectory = replace(about, shift=(x, y, z))
        self.state = PlanState.FLYING
        return Answer.OK

    def fly_piece(self, piece: Piece, t: float) -> Answer:
        """Fly one piece at once."""
        return self._fly(piece, t, PlanState.FLYING)

    @property
    def here(self) -> Goal:
        """Return the last goal, or where the vehicle believes to be when idle."""
        return self._here

    def _now(self, t: float) -> Goal:
        return self.goal(t) or self._here

    def _vertical(self, end: Vertical, t: float, state: PlanState) -> Answer:
        pos, yaw = self._here.pos, _wrapped(self._here.yaw)
        top = np.array([pos[0], pos[1], end.height])
        wanted = yaw if end.yaw is None else end.yaw
        piece = piece_between(resting(pos, yaw), resting(top, _nearest_yaw(yaw, wanted)), end.duration)
        return self._fly(piece, t, state)

    def _fly(self, piece: Piece, t: float, state: PlanState) -> Answer:
        self._trajectory = Piecewise((piece,), t)
        self.state = state
        return Answer.OK


def _wrapped(angle: float) -> float:
    """Return an angle in [-pi, pi)."""
    return (angle + math.pi) % (2.0 * math.pi) - math.pi


def _nearest_yaw(start: float, goal: float) -> float:
    """Return the goal's yaw on the turn nearest to the wrapped start."""
    begin = _wrapped(start)
    return begin + _wrapped(_wrapped(goal) - begin)
