"""Names of frames that are of no vehicle, as of markers without a label: adopted, they would slow the filter.

- No further name is adopted while MOST_LOST vehicles are lost: names that change would fill the state.
- A stray is a vehicle that is lost, was never TRACKED, and is not in the frame any more. Of more than
  MOST_LOST, as after one frame of a thousand names, the first are kept, and the others forgotten.
"""

import numpy as np

from q2q_model.signals.values import Mask, SwarmState, TrackStatus

MOST_LOST = 20
"""Lost vehicles with which no further name is adopted: a fleet that left the room, or names that change."""


def are_many_lost(last: SwarmState | None) -> bool:
    """Return whether no further name is to be adopted after a state."""
    return last is not None and int((last.status == TrackStatus.LOST).sum()) >= MOST_LOST


def kept_tracks(last: SwarmState, confirmed: Mask, in_frame: Mask) -> Mask:
    """Return which tracks of a state are not forgotten, (n,).

    Args:
        last: State of the last frame.
        confirmed: Tracks that were ever TRACKED, (n,).
        in_frame: Tracks with a row in the last frame, (n,).
    """
    stray = (last.status == TrackStatus.LOST) & ~confirmed & ~in_frame
    return np.asarray(~stray | (np.cumsum(stray) <= MOST_LOST))
