"""Check in flight that commanded thrusts carry the weight of the vehicle that is assumed.

As of recorded flights (q2q_model.identification.push.recorded_push), the median of each vehicle's thrust in
the air is bounded. It is within the bounds if at most half of the thrusts are below, and at most half above.
"""

import numpy as np

from q2q_model.identification.push.log_mass import HEAVIEST, LIGHTEST
from q2q_model.identification.push.push_samples import FEWEST_FREE, FLOOR
from q2q_model.signals.values import Names, SwarmCommand, SwarmState, rows_by_name
from q2q_model.vehicle.constants import Vehicle

LIGHT, HEAVY, AIRBORNE = range(3)
"""Columns of the counts of each vehicle."""


class CarriedWeight:
    """Counts of each vehicle's ticks in the air, and of those with thrusts beyond a bound."""

    def __init__(self, vehicle: Vehicle) -> None:
        self._vehicle = vehicle
        self._names: Names = ()
        self._counts = np.zeros((0, 3))

    def update(self, state: SwarmState, command: SwarmCommand) -> None:
        """Count one tick."""
        if state.names != self._names:
            self._counts = rows_by_name(self._counts, self._names, state.names)
            self._names = state.names
        thrust = rows_by_name(command.thrust, command.names, state.names, np.nan)
        share = thrust / self._vehicle.hover_thrust
        airborne = np.isfinite(share) & (state.pos[:, 2] > FLOOR)
        beyond = np.stack([share < LIGHTEST, share > HEAVIEST, np.isfinite(share)], axis=-1)
        self._counts += beyond & airborne[:, None]

    def judged(self) -> bool:
        """Return whether a vehicle has been in the air for long enough."""
        return bool((self._counts[:, AIRBORNE] >= FEWEST_FREE).any())

    def doubt(self) -> str:
        """Return why the vehicle cannot be the one that flies; empty if it can."""
        light, heavy, airborne = self._counts.T
        off = (airborne >= FEWEST_FREE) & (2 * np.maximum(light, heavy) > airborne)
        if not off.any():
            return ""
        i = int(off.argmax())
        side = f"below {LIGHTEST:g}" if light[i] > heavy[i] else f"above {HEAVIEST:g}"
        return (
            f"the median thrust of {self._names[i]} in the air is {side} times the weight of "
            f"{self._vehicle.name}: name the vehicle with --vehicle and send commands in newtons"
        )
