"""Trails of vehicles and of the air from their rotors, for the view."""

from collections import deque
from dataclasses import dataclass, field

from q2q_model.signals.values import Array, Three


@dataclass(slots=True)
class Trail:
    """Recent positions of one vehicle, each with its time [s]."""

    points: deque[tuple[float, Three]] = field(default_factory=deque)

    def add(self, t: float, point: Three, rate_hz: float) -> None:
        """Add a point if the last is old enough."""
        if not self.points or t - self.points[-1][0] >= (1.0 - 1e-6) / rate_hz:
            self.points.append((t, point))

    def forget(self, t: float, seconds: float) -> None:
        """Drop points older than `seconds` [s] at time t [s], or all if time jumps back."""
        if self.points and t < self.points[-1][0]:
            self.points.clear()
        while self.points and t - self.points[0][0] > seconds:
            self.points.popleft()

    def as_points(self) -> tuple[Three, ...]:
        """Return the points, oldest first."""
        return tuple(point for _, point in self.points)


@dataclass(slots=True)
class AirTrail:
    """Recent positions and thrust axes of one vehicle, each with its time [s]."""

    parcels: deque[tuple[float, Array, Array]] = field(default_factory=deque)

    def add(self, t: float, pos: Array, axis: Array, longest: float) -> None:
        """Add the air that leaves pos (3,) [m] now, against axis (3,); drop air older than `longest` [s]."""
        if self.parcels and t <= self.parcels[-1][0]:
            self.parcels.clear()
        self.parcels.append((t, pos, axis))
        while t - self.parcels[0][0] > longest:
            self.parcels.popleft()

    def at(self, t: float, speed: float) -> tuple[Three, ...]:
        """Return the positions of the air at time t [s], the youngest first."""
        return tuple(point_of(pos - axis * speed * (t - left)) for left, pos, axis in reversed(self.parcels))


def point_of(pos: Array) -> Three:
    """Return a position (3,) as plain numbers."""
    x, y, z = pos.tolist()
    return x, y, z
