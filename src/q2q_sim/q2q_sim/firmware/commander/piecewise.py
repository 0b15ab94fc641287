"""Evaluation of a piecewise polynomial trajectory: shifted, rotated, scaled in time, or reversed.

Source: firmware: modules/src/pptraj.c (piecewise_eval, piecewise_eval_reversed). After its end a trajectory
rests at its last point. A time scale of 2 takes twice as long. Reversed, it is shifted but not rotated.
"""

from dataclasses import dataclass

import numpy as np

from q2q_model.signals.values import Array
from q2q_sim.firmware.commander.polynomial import ORDER, Goal, Piece, cos_sin, goal_at, goal_at_rest


@dataclass(frozen=True, slots=True)
class StoredBytes:
    """Bytes of the trajectory memory with an uploaded trajectory."""

    place: range
    content: bytes
    """What they were when it was started."""


@dataclass(frozen=True, slots=True)
class Piecewise:
    """Trajectory being flown."""

    pieces: tuple[Piece, ...]
    """At least one."""
    begin: float
    """Start time [s]."""
    timescale: float = 1.0
    backwards: bool = False
    shift: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Added to every position [m], world."""
    turn: float = 0.0
    """Rotation about the world's z before the shift [rad]; forwards only."""
    stored: StoredBytes | None = None
    """Its bytes in the trajectory memory; None if it was not uploaded."""

    @property
    def duration(self) -> float:
        """Return the duration [s]."""
        return sum(piece.duration for piece in self.pieces) * self.timescale

    @np.errstate(all="ignore")
    def goal(self, t: float) -> Goal:
        """Return the goal at time t [s]."""
        since = t - self.begin
        return self._backward(since) if self.backwards else self._forward(since)

    def _forward(self, since: float) -> Goal:
        for piece in self.pieces:
            length = piece.duration * self.timescale
            if since <= length:
                return self._turned(goal_at(_stretched(piece, self.timescale), since))
            since -= length
        last = goal_at(self.pieces[-1], self.pieces[-1].duration)
        return self._turned(goal_at_rest(last.pos, last.yaw))

    def _backward(self, since: float) -> Goal:
        for piece in reversed(self.pieces):
            length = piece.duration * self.timescale
            if since <= length:
                return self._mirrored(goal_at(_stretched(piece, self.timescale), length - since))
            since -= length
        first = goal_at(self.pieces[0], 0.0)
        return self._mirrored(goal_at_rest(first.pos, first.yaw))

    def _turned(self, goal: Goal) -> Goal:
        c, s = cos_sin(self.turn)
        turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        pos = turn @ goal.pos + np.array(self.shift)
        return Goal(pos, turn @ goal.vel, turn @ goal.acc, goal.yaw + self.turn, goal.ang_vel_body)

    def _mirrored(self, goal: Goal) -> Goal:
        return Goal(goal.pos + np.array(self.shift), -goal.vel, goal.acc, goal.yaw, -goal.ang_vel_body)


@np.errstate(all="ignore")
def _stretched(piece: Piece, scale: float) -> Piece:
    """Return the piece with another time scale."""
    powers: Array = scale ** -np.arange(ORDER, dtype=np.float64)
    return Piece(piece.duration * scale, piece.coefficients * powers)
