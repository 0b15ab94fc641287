"""What one tick's samples make of the position tracks."""

from dataclasses import dataclass

import numpy as np

from q2q_model.signals.values import Array, Mask, Rows


@dataclass(frozen=True, slots=True)
class TrackUpdate:
    """Result of one tick, one row per vehicle."""

    pos: Array
    """Position [m], (n, 3); zero for a vehicle never seen."""
    vel: Array
    """Velocity [m/s], (n, 3); zero for a lost vehicle."""
    source: Rows
    """Row of the accepted sample, (n,): another row where labels were swapped, -1 where none."""
    restarted: Mask
    """Tracks restarted at a true jump or a thaw, (n,)."""
    trusted: Mask
    """Tracks with an accepted sample that is not doubtful, and confirmed, (n,)."""
    frozen: Mask
    """Vehicles whose poses repeat though there is noise, (n,)."""
    nominal: bool
    """Every track is confirmed, and accepted the sample of its own name."""

    @property
    def accepted(self) -> Mask:
        """Return which tracks accepted a sample, (n,)."""
        return np.asarray(self.source >= 0)

    @property
    def borrowed(self) -> Mask:
        """Return which tracks accepted a sample of another name, (n,)."""
        return np.asarray(self.accepted & (self.source != np.arange(len(self.source))))
