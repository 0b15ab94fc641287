"""Vehicles as reported by Crazyswarm2's server, and when to read their parameters again."""

import math
from dataclasses import dataclass

from q2q_control.crazyswarm.server_vehicle import ServerVehicle
from q2q_control.flight_procedure.observation import VehicleReport
from q2q_model.signals.values import Names

READ_S = 1.0
"""Period of reading parameters [s]."""
ARM_S = 1.0
"""Assumed duration of arming if vehicles do not report it [s]."""


@dataclass(slots=True)
class ReportedVehicles:
    """Vehicles of a server."""

    vehicles: tuple[ServerVehicle, ...]
    read_at: float = -math.inf
    """Time of the last read of their parameters [s]."""

    def poll_read(self, t: float) -> bool:
        """Return whether to read parameters at time t [s]; if so, the period starts again."""
        if t - self.read_at < READ_S:
            return False
        self.read_at = t
        return True

    def reports(self, t: float, *, connected: Names) -> tuple[VehicleReport, ...]:
        """Return the report of every vehicle at time t [s], with which are connected."""
        return tuple(one.report(t, connected=one.name in connected) for one in self.vehicles)

    def armed(self, ordered: float, t: float) -> bool:
        """Return whether all have armed since `ordered` [s]: by their status, without one after ARM_S."""
        armed = [one.armed_since(ordered) for one in self.vehicles]
        return all(t - ordered > ARM_S if one is None else one for one in armed)
