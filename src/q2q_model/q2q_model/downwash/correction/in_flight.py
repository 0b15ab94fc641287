"""Vehicles that their rotors carry.

A vehicle on the ground is carried by it, and an accelerometer feels that force as a push of up to the weight.
As for the firmware app, a vehicle flies from when its thrust exceeds LIFTED_SHARE of the weight; it stands
again when the thrust falls below LANDED_SHARE.
"""

import numpy as np

from q2q_model.signals.values import Array, Mask, Names, rows_by_name
from q2q_model.vehicle.constants import Vehicle

LIFTED_SHARE = 0.9
"""Thrust over weight from which on a vehicle flies [-]: below, the ground carries it."""
LANDED_SHARE = 0.5
"""Thrust over weight below which a vehicle has landed [-]: 0.71 and more in the air in public flights."""


class InFlight:
    """Memory of which vehicles fly."""

    def __init__(self, vehicle: Vehicle) -> None:
        self._weight = vehicle.hover_thrust
        self.reset()

    def reset(self) -> None:
        """Forget all vehicles: none flies."""
        self._names: Names = ()
        self._flying: Mask = np.zeros(0, dtype=np.bool_)

    def update(self, names: Names, thrust: Array) -> Mask:
        """Return which vehicles fly, (n,), by the thrust of their rotors [N], (n,); not where it is NaN."""
        before = rows_by_name(self._flying, self._names, names)
        self._flying = thrust > self._weight * np.where(before, LANDED_SHARE, LIFTED_SHARE)
        self._names = names
        return self._flying
