"""Waypoints that no trajectory can serve: in each other's zone at nearly one time, or beyond a wall."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from q2q_model.signals.values import Array
from q2q_planner.offline.certificate.convex_zone import ConvexZone
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints
from q2q_planner.offline.walls import Walls

FASTEST = 10.0
"""A vehicle comes to its waypoint at less than this speed [m/s], so it was in a zone shortly before, too."""


class InfeasibleError(ValueError):
    """Error when no certified plan was found, naming the pair in conflict, or vehicle and wall."""


class _Held(NamedTuple):
    """A waypoint, and where another vehicle is held then, or shortly before or after."""

    first: int
    waypoint: int
    second: int
    other: int
    """Waypoint of `second`."""
    gap: float
    """Time between the two [s]."""


def check_apart(swarm: Sequence[VehicleWaypoints], zone: ConvexZone) -> None:
    """Raise if waypoints at nearly one time, or a rest after the last one, lie in each other's zone."""
    deepest = -float(zone.signed_distance(np.zeros(3)))
    held = list(_held_together(swarm, deepest / FASTEST))
    if not held:
        return
    rel = [
        np.subtract(swarm[one.first].waypoints[one.waypoint].pos, swarm[one.second].waypoints[one.other].pos)
        for one in held
    ]
    clearance = zone.signed_distance(np.array(rel))
    inside = np.flatnonzero(clearance + FASTEST * np.array([one.gap for one in held]) <= 0.0)
    if inside.size:
        words = _held_words(swarm, held[inside[0]], -clearance[inside[0]])
        raise InfeasibleError(f"{words}; no trajectory can keep them apart")


def _held_words(swarm: Sequence[VehicleWaypoints], held: _Held, depth: float) -> str:
    first, second = swarm[held.first], swarm[held.second]
    both = f"{first.name}, waypoint {held.waypoint} and {second.name}, waypoint {held.other}"
    later = f" and {second.waypoints[held.other].t} s" if held.gap else ""
    t = f"t = {first.waypoints[held.waypoint].t} s{later}"
    return f"{both} lie {depth:.3g} m inside each other's zone at {t}"


def check_inside(swarm: Sequence[VehicleWaypoints], walls: Walls) -> None:
    """Raise if a waypoint is not within the walls."""
    for vehicle in swarm:
        distance = walls.distances(np.array([waypoint.pos for waypoint in vehicle.waypoints])).min(axis=-1)
        if distance.min() <= 0.0:
            at = int(distance.argmin())
            where = f"is {-distance[at]:.3g} m beyond" if distance[at] < 0.0 else "lies on"
            allowed = f"must be {walls}, walls excluded"
            raise InfeasibleError(f"{vehicle.name}, waypoint {at} {where} a wall; {allowed}")


def _held_together(swarm: Sequence[VehicleWaypoints], most: float) -> Iterator[_Held]:
    """Yield every waypoint with those of each other vehicle that are at most `most` [s] apart."""
    times = [vehicle.times for vehicle in swarm]
    for i, vehicle in enumerate(swarm):
        for at, waypoint in enumerate(vehicle.waypoints):
            for j, there in enumerate(times):
                other, gap = _held_at(there, waypoint.t)
                if j != i and gap <= most:
                    yield _Held(i, at, j, other, gap)


def _held_at(times: Array, t: float) -> tuple[int, float]:
    """Return the waypoint, of those at `times`, that is nearest to time t [s], and how far it is from it [s].

    A vehicle is at its last waypoint for ever after.
    """
    if t >= times[-1]:
        return len(times) - 1, 0.0
    near = int(np.abs(times - t).argmin())
    return near, float(abs(times[near] - t))
