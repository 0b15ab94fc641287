"""Motions that a tick chooses between: the desired one of every vehicle, or the rest of what was proven."""

from typing import NamedTuple

import numpy as np

from q2q_model.compiled import compiled
from q2q_planner.online.safe.choice.desired_motion import DesiredMotion, Kinds
from q2q_planner.online.safe.motion.committed_motion import MotionRows
from q2q_planner.online.safe.motion.traffic import TrafficRows
from q2q_planner.online.safe.stopping.braking import Motions
from q2q_planner.online.safe.stopping.broad_phase import Pairs


class PairedTraffic(NamedTuple):
    """All vehicles of a tick; arrays of TrafficTable."""

    rows: TrafficRows
    pairs: Pairs
    certain: Motions


class CandidateMotions(NamedTuple):
    """Two motions of each row."""

    new: Motions
    """Of external vehicles, every motion that they may fly."""
    old: Motions
    """Rest of the old motions; of external vehicles, the motion that they certainly fly."""
    kind: Kinds
    """Of the swarm's new motions, (n,)."""


@compiled
def new_motions(traffic: TrafficRows, desired: DesiredMotion, hold: float) -> Motions:
    """Return the new motions of all rows; of external vehicles, every motion that they may fly.

    Args:
        traffic: all vehicles.
        desired: of the swarm.
        hold: time for which they are held [s].
    """
    still = np.zeros((len(traffic.pos) - len(desired.acc), 3))
    acc, jerk = np.concatenate((desired.acc, still)), np.concatenate((desired.jerk, still))
    held = np.full(len(traffic.pos), hold)
    return Motions(traffic.pos, traffic.vel, acc, held, traffic.growth, jerk)


@compiled
def old_motions(rows: MotionRows, traffic: TrafficRows, certain: Motions) -> Motions:
    """Return the old motions of all n + m rows: the rest of the swarm's, (n,), then `certain`, (m,).

    The swarm's need no growth rate: they are proven. `certain` are those that external vehicles fly.
    """
    own = rows.hold.size
    growth = np.zeros((own, 2))
    growth[:, 0] = traffic.growth[:own, 0]
    return Motions(
        np.concatenate((rows.pos, certain.pos)),
        np.concatenate((rows.vel, certain.vel)),
        np.concatenate((rows.acc, certain.acc)),
        np.concatenate((rows.hold, certain.hold)),
        np.concatenate((growth, certain.growth)),
        np.concatenate((rows.jerk, certain.jerk)),
    )
