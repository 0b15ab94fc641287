"""Remarks on references that determine gains less well than the intervals of these say."""

from collections.abc import Sequence

import numpy as np

from q2q_model.flights.sampled_reference import HOLD_S, SampledReference
from q2q_model.signals.values import Names

FITTED = "fitted to their positions, even for a controller that has none; map FullState or reference"
BOTH_FITTED = f"have no velocity and acceleration: both are {FITTED}"
VEL_FITTED = f"have no velocity: it is {FITTED}"
ACC_FITTED = f"have no acceleration: it is {FITTED}"
OFF_TICKS = (
    "do not come at ticks of the poses, or not evenly: the gains may be outside their intervals by some per "
    "cent"
)
GOALS = (
    f"mostly stand for more than {HOLD_S:g} s: they are read as held goals; if they belong to a moving "
    "trajectory, the gains are wrong"
)


def reference_remarks(flight: str, names: Names, pieces: Sequence[SampledReference]) -> list[str]:
    """Return remarks on the references of some vehicles in the pieces of a flight that are used."""
    vel, acc = np.any([one.fitted for one in pieces], axis=0).T
    told = (
        (vel & acc, BOTH_FITTED),
        (vel & ~acc, VEL_FITTED),
        (acc & ~vel, ACC_FITTED),
        (np.any([one.uneven for one in pieces], axis=0), OFF_TICKS),
        (np.any([one.goals for one in pieces], axis=0), GOALS),
    )
    return [
        f"{flight}: references of {', '.join(np.array(names)[which])} {words}"
        for which, words in told
        if which.any()
    ]
