"""Conditions of a licence: where the vehicles stand, the air, the limits, and the time it may take."""

from dataclasses import dataclass, field

from q2q_model.signals.values import Three
from q2q_sim.licence.crazyflie_py.served_vehicles import ServedVehicle
from q2q_sim.licence.room.licence_room import LicenceParams
from q2q_sim.licence.rules.licence_limits import LicenceLimits
from q2q_sim.sensors.range_finder import RoomBox

SPACING = 1.0
"""Distance of neighbours on the floor [m]."""
ASIDE = 1.5
"""Distance of the outermost from the walls [m]: a leg of 1 m does not end at one."""


@dataclass(frozen=True, slots=True)
class LicenceOptions:
    """Conditions of a licence."""

    starts: tuple[Three, ...] = ()
    """x, y [m], yaw [rad] of the vehicles in the order of their URIs; empty for rows along y, SPACING apart
    (`rows_of`)."""
    limits: LicenceLimits = field(default_factory=LicenceLimits)
    air: str = "room"
    seed: int = 0
    arming: bool = False
    scanned: tuple[str, ...] = ()
    """URIs that a scan answers."""
    served: tuple[ServedVehicle, ...] = ()
    """Vehicles of a crazyflies.yaml; empty if there is none."""
    limit: float = 300.0
    """Longest flight without faults [s]."""
    jobs: int = 2
    budget: float = 540.0
    """Wall time after which no flight but the first starts [s]."""

    def params(self, count: int) -> LicenceParams:
        """Return the room with `count` vehicles."""
        served = tuple(one.start for one in self.served)
        starts = self.starts[:count] if len(self.starts) >= count else served or self.rows_of(count)
        room = RoomBox(*self.limits.half_room, self.limits.ceiling)
        return LicenceParams(starts, self.air, self.seed, self.arming, room)

    def rows_of(self, count: int) -> tuple[Three, ...]:
        """Return starts of `count` vehicles in rows along y, as few as the room has space for."""
        fit = max(1 + int(2.0 * (self.limits.half_room[1] - ASIDE) / SPACING), 1)
        rows = -(-count // fit)
        wide = -(-count // rows)
        middle_x, middle_y = 0.5 * (rows - 1), 0.5 * (wide - 1)
        return tuple(
            (SPACING * (k // wide - middle_x), SPACING * (k % wide - middle_y), 0.0) for k in range(count)
        )
