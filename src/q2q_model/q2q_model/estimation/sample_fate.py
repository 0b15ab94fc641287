"""Say what became of the samples of one tick."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from q2q_model.flights.outliers import Mask
from q2q_model.signals.values import Array


@dataclass(frozen=True, slots=True)
class SampleFates:
    """Outcome of each sample, one row a vehicle."""

    pos: Array
    """Position [m], (n, 3); zero for a vehicle never seen."""
    vel: Array
    """Velocity [m/s], (n, 3); zero for a lost vehicle."""
    accepted: Mask
    source: NDArray[np.intp]
    """Whose sample was taken, (n,): another row where markers were swapped, -1 where none."""
    restarted: Mask
    """Taken as a true jump."""
    trusted: Mask
    """Accepted, and not the only sample that says so: the first of a track is not."""
    plain: bool
    """Every vehicle's own sample was taken."""
    none_rejected: bool
    """No sample was refused or taken for another's: some may be absent."""

    @property
    def lent(self) -> Mask:
        """Return who took another's sample, (n,)."""
        return np.asarray(self.accepted & (self.source != np.arange(len(self.source))))
