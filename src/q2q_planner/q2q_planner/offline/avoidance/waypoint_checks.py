"""Waypoints that no trajectory can serve: in each other's zone at one time, or beyond a wall."""

from collections.abc import Iterator, Sequence

import numpy as np

from q2q_model.signals.values import Array
from q2q_planner.offline.certificate.convex_zone import ConvexZone
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints
from q2q_planner.offline.walls import Walls

SAME_MOMENT = 1e-3
"""Time difference within which a waypoint is named in an error [s]."""


class InfeasibleError(ValueError):
    """Error when no certified plan was found, naming the pair in conflict, or vehicle and wall."""


def check_apart(swarm: Sequence[VehicleWaypoints], zone: ConvexZone) -> None:
    """Raise if waypoints at the same time, or a rest after the last one, lie in each other's zone."""
    held = list(_held_together(swarm))
    if not held:
        return
    rel = [
        np.subtract(swarm[i].waypoints[at].pos, swarm[j].waypoints[other].pos) for (i, at), (j, other) in held
    ]
    clearance = zone.signed_distance(np.array(rel))
    inside = np.flatnonzero(clearance <= 0.0)
    if inside.size:
        (i, at), (j, other) = held[inside[0]]
        both = f"{swarm[i].name}, waypoint {at} and {swarm[j].name}, waypoint {other}"
        depth = f"{-clearance[inside[0]]:.3g} m inside each other's zone at t = {swarm[i].waypoints[at].t} s"
        raise InfeasibleError(f"{both} lie {depth}; no trajectory can keep them apart")


def check_inside(swarm: Sequence[VehicleWaypoints], walls: Walls) -> None:
    """Raise if a waypoint is not within the walls."""
    for vehicle in swarm:
        distance = walls.distances(np.array([waypoint.pos for waypoint in vehicle.waypoints])).min(axis=-1)
        if distance.min() <= 0.0:
            at = int(distance.argmin())
            where = f"is {-distance[at]:.3g} m beyond" if distance[at] < 0.0 else "lies on"
            allowed = f"must be {walls}, walls excluded"
            raise InfeasibleError(f"{vehicle.name}, waypoint {at} {where} a wall; {allowed}")


def _held_together(swarm: Sequence[VehicleWaypoints]) -> Iterator[tuple[tuple[int, int], tuple[int, int]]]:
    """Yield (vehicle, waypoint) and each (other vehicle, waypoint) that is held at its time."""
    times = [vehicle.times for vehicle in swarm]
    for i, vehicle in enumerate(swarm):
        for at, waypoint in enumerate(vehicle.waypoints):
            for j, there in enumerate(times):
                other = _held_at(there, waypoint.t)
                if j != i and other is not None:
                    yield (i, at), (j, other)


def _held_at(times: Array, t: float) -> int | None:
    """Return the waypoint, of those at `times`, at which a vehicle is at time t [s], or None."""
    if t >= times[-1]:
        return len(times) - 1
    near = int(np.abs(times - t).argmin())
    return near if abs(times[near] - t) < SAME_MOMENT else None
