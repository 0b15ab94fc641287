"""Speed at which downwash travels down in a named air."""

from math import inf

from q2q_model.own_class import is_own_class
from q2q_sim.air.air_names import LAWS, ROOM, AirError, is_recorded
from q2q_sim.air.lookup.find_air import find_air
from q2q_sim.air.room_air import RoomAir
from q2q_sim.air.wake_laws import MEASURED, MEASURED_SPEED, wake_by_name


def travel_speed(name: str) -> float:
    """Return the speed in an air, by its name or that in a bag [m/s]: infinite if it acts at once.

    Where it is unknown (no name, a class, a file that has gone), it is that of two real vehicles.
    """
    air = name.partition(" without ")[0]
    if air in LAWS:
        return MEASURED_SPEED if wake_by_name(air) == MEASURED else inf
    try:
        found = None if not air or is_own_class(air) else find_air(ROOM if is_recorded(air) else air)
    except (AirError, OSError):
        found = None
    jet = found.jet if isinstance(found, RoomAir) else None
    return MEASURED_SPEED if jet is None else jet.travel_speed_mps
