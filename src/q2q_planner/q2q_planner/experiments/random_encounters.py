"""Random encounters: plans without avoidance, and the communication of their vehicles.

Vehicles are `together`, under one replanner for all; or `apart`, under one replanner each, which receives one
message of every other vehicle per tick, up to `delay` late (so messages may overtake each other) and lost
with probability `loss`.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from q2q_model.signals.values import Array
from q2q_model.trajectory.polynomials import SwarmPlan
from q2q_planner.offline.minimum_snap.minimum_snap import minimum_snap_plan
from q2q_planner.offline.minimum_snap.waypoints import waypoints_through

TICKS = (0.01, 0.02, 0.05)
"""Ticks of replanners at 100, 50 or 20 Hz [s]."""
LATEST = 0.3
"""Largest delay of a message [s]."""
MOST_LOST = 0.1
"""Largest share of lost messages."""
MOSTLY_CLEAR = 0.8
"""Share of encounters whose starts and ends are drawn until they are out of each other's zones."""
DRAWS = 100
"""Most draws of starts and ends."""
APART = 0.4
"""Horizontal distance at which two vehicles are out of each other's zones [m]."""

Shape = Literal["lines", "curves", "ring"]
SHAPES: tuple[Shape, ...] = ("lines", "curves", "ring")
"""Random straight lines; through a random point without stopping; to the opposite side of a ring."""


@dataclass(frozen=True, slots=True, eq=False)
class Encounter:
    """Vehicles that meet, and how they receive each other's states."""

    plan: SwarmPlan
    tick: float
    """[s]"""
    apart: bool
    delay: Array
    """Largest delay of messages from j to i [s], (n, n); unused together."""
    loss: float
    """Share of lost messages."""


def random_encounter(generator: np.random.Generator, most: int = 10, clear_by: float = APART) -> Encounter:
    """Return an encounter of 2 to `most` vehicles at up to about 2 m/s; half of them apart.

    Most start and end at least `clear_by` [m] apart horizontally.
    """
    n = int(generator.integers(2, most + 1))
    shape = SHAPES[generator.integers(len(SHAPES))]
    end, side = generator.uniform(3.0, 5.0), generator.uniform(1.5, 2.0 + 0.2 * n)
    points = _mostly_clear_points(generator, shape, n, side, clear_by)
    times = np.linspace(0.0, end, points.shape[1])
    swarm = [waypoints_through(f"cf{row}", times, own) for row, own in enumerate(points)]
    plan = minimum_snap_plan(swarm, "free")
    delay, tick = generator.uniform(0.0, LATEST, (n, n)), float(generator.choice(TICKS))
    loss = float(generator.uniform(0.0, MOST_LOST))
    return Encounter(plan, tick, bool(generator.integers(2)), delay, loss)


def _mostly_clear_points(
    generator: np.random.Generator, shape: Shape, n: int, side: float, clear_by: float
) -> Array:
    """Return waypoints [m], (n, 2 or 3, 3), of which most starts and ends are clear of each other."""
    points = _points(generator, shape, n, side)
    clear = generator.random() < MOSTLY_CLEAR
    for _ in range(DRAWS if clear else 0):
        if all_clear(points[:, 0], clear_by) and all_clear(points[:, -1], clear_by):
            break
        points = _points(generator, shape, n, side)
    return points


def _points(generator: np.random.Generator, shape: Shape, n: int, side: float) -> Array:
    """Return waypoints [m], (n, 2 or 3, 3)."""
    box = np.array([side / 2, side / 2, 0.6])
    if shape == "ring":
        angle = generator.uniform(0.0, 2.0 * np.pi) + 2.0 * np.pi * np.arange(n) / n
        height = generator.choice([0.0, 0.3]) * generator.normal(size=n) + 1.2
        out = np.stack([0.5 * side * np.cos(angle), 0.5 * side * np.sin(angle), height], axis=-1)
        return np.stack([out, out * [-1.0, -1.0, 1.0]], axis=1)
    stops = 2 if shape == "lines" else 3
    return np.asarray(generator.uniform(-1.0, 1.0, (n, stops, 3)) * box + [0.0, 0.0, 1.2])


def all_clear(pos: Array, clear_by: float = APART) -> bool:
    """Return whether all positions (n, 3) are more than `clear_by` apart horizontally [m]."""
    i, j = np.triu_indices(len(pos), 1)
    return bool(np.hypot(*(pos[i] - pos[j])[:, :2].T).min() > clear_by)
