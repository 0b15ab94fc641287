"""Read a trajectory of polynomial pieces: shifted, turned, slowed, or backwards.

Source: firmware: modules/src/pptraj.c (piecewise_eval, piecewise_eval_reversed). After its end a trajectory
rests at its last point. A time scale of 2 takes twice as long.
"""

import math
from dataclasses import dataclass

import numpy as np

from q2q_model.signals import Array
from q2q_sim.onboard.polynomial import ORDER, Goal, Piece, goal_at, resting


@dataclass(frozen=True, slots=True)
class Piecewise:
    """Hold a trajectory under way."""

    pieces: tuple[Piece, ...]
    """At least one."""
    begin: float
    """When it starts [s]."""
    timescale: float = 1.0
    backwards: bool = False
    shift: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Added to every position [m], world."""
    turn: float = 0.0
    """Turns everything about the world's z before the shift [rad]."""

    @property
    def duration(self) -> float:
        """Return how long it takes [s]."""
        return sum(piece.duration for piece in self.pieces) * self.timescale

    def goal(self, t: float) -> Goal:
        """Return the goal at time t [s]."""
        since = max(t - self.begin, 0.0)
        if self.backwards:
            since = self.duration - since
        return self._placed(self._unplaced(since))

    def _unplaced(self, since: float) -> Goal:
        if not 0.0 <= since <= self.duration:
            return self._end()
        for piece in self.pieces:
            length = piece.duration * self.timescale
            if since <= length:
                return goal_at(_stretched(piece, self.timescale), since)
            since -= length
        return self._end()  # rounding carried `since` past the last piece

    def _end(self) -> Goal:
        piece, tau = (self.pieces[0], 0.0) if self.backwards else (self.pieces[-1], self.pieces[-1].duration)
        last = goal_at(piece, tau)
        return resting(last.pos, last.yaw)

    def _placed(self, goal: Goal) -> Goal:
        c, s = math.cos(self.turn), math.sin(self.turn)
        turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        sign = -1.0 if self.backwards else 1.0
        pos = turn @ goal.pos + np.array(self.shift)
        return Goal(
            pos, sign * (turn @ goal.vel), turn @ goal.acc, goal.yaw + self.turn, sign * goal.ang_vel_body
        )


def _stretched(piece: Piece, scale: float) -> Piece:
    """Return the piece at another pace."""
    powers: Array = scale ** -np.arange(ORDER, dtype=np.float64)
    return Piece(piece.duration * scale, piece.coefficients * powers)
