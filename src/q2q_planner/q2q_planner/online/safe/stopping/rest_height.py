"""Height at which a motion comes to rest."""

import numpy as np

from q2q_model.compiled import HOT, compiled
from q2q_planner.online.safe.stopping.braking import BrakingLaw, Motions
from q2q_planner.online.safe.stopping.jerk_limited import stopped_height


@compiled(**HOT)
def rest_height(motions: Motions, row: int, law: BrakingLaw) -> float:
    """Return the height at which the motion of a row rests, or the one where it is if that is lower [m]."""
    z, hold = motions.pos[row, 2], motions.hold[row]
    if law.jerk > 0.0:
        start = z, motions.vel[row, 2], motions.acc[row, 2]
        return float(min(z, stopped_height(start, motions.jerk[row, 2], hold, law)))
    vel, acc = motions.vel, motions.acc
    fall = vel[row, 2] + acc[row, 2] * hold
    x, y = vel[row, 0] + acc[row, 0] * hold, vel[row, 1] + acc[row, 1] * hold
    held = z + hold * (vel[row, 2] + 0.5 * hold * acc[row, 2])
    return float(min(z, held + 0.5 * fall * np.sqrt(x * x + y * y + fall * fall) / law.brake))
