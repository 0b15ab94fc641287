"""Check of the places at which vehicles are told to start: a wrong one is no fault of the program."""

from collections.abc import Mapping
from itertools import combinations
from math import dist

from q2q_model.signals.values import Three
from q2q_sim.licence.rules.licence_limits import LicenceLimits


def check_starts(starts: Mapping[str, Three], limits: LicenceLimits) -> None:
    """Raise ValueError for a start outside the room, and for two at which vehicles touch; each has a name."""
    half_x, half_y = limits.half_room
    for name, (x, y, _) in starts.items():
        if not (abs(x) <= half_x and abs(y) <= half_y):
            room = f"the room is {2.0 * half_x:g} by {2.0 * half_y:g} m around the origin"
            raise ValueError(f"{name} is at {x:g}, {y:g} m: {room}; move it, or set --room")
    for (name, one), (other_name, other) in combinations(starts.items(), 2):
        apart = dist(one[:2], other[:2])
        if apart < limits.gap:
            raise ValueError(f"{name} and {other_name} are {apart:.2f} m apart (minimum {limits.gap:g} m)")
