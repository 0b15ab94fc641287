"""Ticks of outputs whose frames have the stamps of other ticks.

The simulator stamps the truth with the time of its tick, and the nodes stamp their outputs with the stamp of
the frame. A clock jump, a late or a repeated frame makes that the time of another tick. In lockstep each tick
has one frame and one output of each node for it, so that the k-th is that of the k-th tick.
"""

import numpy as np

from q2q_model.flights.flight_ticks import GAP
from q2q_model.signals.values import Array

OUTPUTS = ("reference", "reference_safe", "interference", "command")
"""Topics of what was flown at a tick; state and mocap are about the time of their stamps."""
MOST_AGAIN = 0.01
"""Largest fraction of ticks whose frames were sent again [-]."""


def output_ticks(truth: Array, frames: Array, outputs: Array) -> Array:
    """Return the tick of each output [s], (K,): its own stamp, unless frames have those of other ticks.

    A frame that is sent again, after an output that was late, is answered again, under the same stamp.

    Args:
        truth: stamps of the truth in the order of recording [s]; none without a simulator.
        frames: stamps of motion capture [s].
        outputs: stamps of the outputs of one node on a topic in the order of recording [s], (K,).
    """
    surplus = len(outputs) - len(truth)
    again = np.diff(outputs, prepend=np.nan) == 0.0
    again &= np.cumsum(again) <= surplus
    each_has_one = again.sum() == surplus <= MOST_AGAIN * len(truth) and len(frames) >= len(truth)
    if each_has_one and _is_gapless(truth) and not np.array_equal(np.unique(frames), truth):
        return np.asarray(truth[np.cumsum(~again) - 1])
    return outputs


def _is_gapless(stamps: Array) -> bool:
    """Return whether stamps are those of consecutive ticks."""
    steps = np.diff(stamps)
    return bool(len(steps)) and bool(steps.min() > 0.0) and bool(steps.max() < GAP * np.median(steps))
