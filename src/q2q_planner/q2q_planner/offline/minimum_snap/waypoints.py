"""Waypoints of each vehicle, checked for what a trajectory can meet.

A waypoint is (t, x, y, z, yaw) of eq. (17). Yaw is not wrapped: 0 to 2 pi is a full turn.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import isfinite

import numpy as np
from numpy.typing import ArrayLike

from q2q_model.signals.values import Array, Three

SHORTEST_PIECE = 1e-3
"""Minimum time between waypoints [s]: a tenth of the 100 Hz tick."""

FARTHEST, LONGEST, MOST_TURN = 1e4, 1e5, 1e4
"""Largest coordinate [m], time [s] and yaw [rad]: beyond, the rounding of a 7th power of time
exceeds a micrometre."""


@dataclass(frozen=True, slots=True)
class Waypoint:
    """One point of a flight."""

    t: float
    """Time from the plan's start [s]."""
    pos: Three
    """Position [m], world."""
    yaw: float = 0.0
    """[rad]"""


@dataclass(frozen=True, slots=True)
class VehicleWaypoints:
    """Waypoints of one vehicle, in the order of their times, at least two."""

    name: str
    waypoints: tuple[Waypoint, ...]

    def __post_init__(self) -> None:
        """Check numbers and times.

        Raises:
            ValueError: naming vehicle, waypoint, value and bound.
        """
        if len(self.waypoints) < 2:
            raise ValueError(f"{self.name}: {len(self.waypoints)} waypoint(s) given; must be at least 2")
        for index, waypoint in enumerate(self.waypoints):
            _check_finite(f"{self.name}, waypoint {index}", waypoint)
        for index, (before, after) in enumerate(pairwise(self.waypoints), start=1):
            _check_rising(f"{self.name}, waypoint {index}", before.t, after.t)

    @property
    def times(self) -> Array:
        """Return t of each waypoint [s], (m,)."""
        return np.array([waypoint.t for waypoint in self.waypoints], dtype=np.float64)

    @property
    def points(self) -> Array:
        """Return x, y, z [m], yaw [rad] of each waypoint, (m, 4)."""
        return np.array([(*waypoint.pos, waypoint.yaw) for waypoint in self.waypoints], dtype=np.float64)


def waypoints_through(name: str, times: ArrayLike, points: ArrayLike) -> VehicleWaypoints:
    """Return the waypoints of a vehicle: points (m, 3 or 4), x, y, z [m] and yaw [rad], at times (m,) [s]."""
    rows = zip(np.asarray(times, dtype=np.float64).tolist(), np.asarray(points).tolist(), strict=True)
    return VehicleWaypoints(name, tuple(Waypoint(t, (x, y, z), *yaw) for t, (x, y, z, *yaw) in rows))


def check_swarm(swarm: Sequence[VehicleWaypoints]) -> None:
    """Check that a swarm can share one plan: unique names, all starting at t = 0.

    Raises:
        ValueError: naming the vehicle and what is allowed.
    """
    if not swarm:
        raise ValueError("no vehicle given; must be at least 1")
    names = [vehicle.name for vehicle in swarm]
    for name in names:
        if names.count(name) > 1:
            raise ValueError(f"{name}: name given {names.count(name)} times; each vehicle needs its own")
    for vehicle in swarm:
        first = vehicle.waypoints[0].t
        if first != 0.0:
            raise ValueError(
                f"{vehicle.name}, waypoint 0: t = {first} s; the first waypoint must be at t = 0 s"
            )


def _check_finite(where: str, waypoint: Waypoint) -> None:
    named: Iterable[tuple[str, float, float]] = zip(
        ("t", "x", "y", "z", "yaw"),
        (waypoint.t, *waypoint.pos, waypoint.yaw),
        (LONGEST, *3 * (FARTHEST,), MOST_TURN),
        strict=True,
    )
    for symbol, value, most in named:
        if not isfinite(value):
            raise ValueError(f"{where}: {symbol} = {value}; must be a finite number")
        if abs(value) > most:
            raise ValueError(f"{where}: {symbol} = {value:g}; must be in [-{most:g}, {most:g}]")


def _check_rising(where: str, before: float, after: float) -> None:
    if after == before:
        raise ValueError(f"{where}: t = {after} s coincides with the previous waypoint; times must increase")
    if after < before:
        raise ValueError(
            f"{where}: t = {after} s is before the previous waypoint's {before} s; times must increase"
        )
    if after - before < SHORTEST_PIECE:
        raise ValueError(
            f"{where}: {after - before} s after the previous one; must be at least {SHORTEST_PIECE} s"
        )
