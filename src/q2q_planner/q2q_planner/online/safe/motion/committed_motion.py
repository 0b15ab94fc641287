"""Committed motion of a swarm: what every vehicle flies unless a tick chooses a new motion for it."""

from dataclasses import dataclass
from typing import NamedTuple

from q2q_model.signals.values import Array, Mask, Names
from q2q_planner.online.replanner import LONGEST_GAP


class MotionRows(NamedTuple):
    """Committed motion of n vehicles: acc, or where it is bounded jerk, for hold; then braking."""

    pos: Array
    """Modified position [m], (n, 3)."""
    vel: Array
    """[m/s], (n, 3)."""
    acc: Array
    """Held acceleration, or where jerk is bounded that at the start [m/s^2], (n, 3)."""
    hold: Array
    """Remaining hold time [s], (n,)."""
    on_reference: Mask
    """Exactly on its reference, (n,)."""
    pushed: Mask
    """Deviates from its desired acceleration, (n,)."""
    jerk: Array
    """Held jerk [m/s^3], (n, 3); 0 where it is not bounded."""


@dataclass(frozen=True, slots=True)
class CommittedMotion:
    """Motion of every vehicle from t [s] on."""

    t: float
    names: Names
    rows: MotionRows
    dt: float = 0.0
    """Time since the tick before [s]."""

    def with_rows(self, rows: MotionRows) -> "CommittedMotion":
        """Return the motion with other arrays."""
        return CommittedMotion(self.t, self.names, rows, self.dt)


def still_flown(committed: CommittedMotion | None, t: float) -> CommittedMotion | None:
    """Return the motion of the last tick; None where there is none, of no vehicle, or a gap since."""
    if committed is None or not committed.names or abs(t - committed.t) > LONGEST_GAP:
        return None
    return committed
