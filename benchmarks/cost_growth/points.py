"""Measured points: time and memory of every block for each number of vehicles.

Blocks run in turn, tick by tick, as in a flight: with caches as cold as there. The timed ticks are cut into
REPETITIONS parts; a part's figure is the median over its ticks, in processor time, and a point is the median
part with the least and the largest. References run on the same ticks after each part.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from time import process_time

import numpy as np

from cost_growth.held_arrays import array_bytes
from cost_growth.power_law import PowerLaw, power_law
from cost_growth.scene import Scene, scene_of
from cost_growth.timed_blocks import Task, TimedBlock, timed_blocks
from q2q_model.signals.cdr.cdr_writer import encode
from q2q_model.signals.stamps import TICK_S

REPETITIONS = 5
MOST_TICKS, LEAST_TICKS, VEHICLE_TICKS = 200, 20, 4000
"""Bounds of the timed ticks of a size, and between them ticks times vehicles."""
REFERENCE_TICKS = 2
"""Ticks of each part on which a reference runs: some take a second."""
WHOLE = "whole tick without ROS"
IN_TICK = ("mocap filter", "interference", "trajectory", "PID", "guard", "simulator, 5 steps")
"""Blocks of the whole tick, whose arrays count as its own."""


@dataclass(frozen=True, slots=True)
class Point:
    """Cost of a block for one number of vehicles."""

    vehicles: int
    seconds: float
    """Median over the repetitions [s]."""
    least: float
    most: float
    reference: float
    """Of the same job [s]."""
    held: int
    """Arrays that the block keeps from tick to tick [byte]."""
    message: int
    """One SwarmState message of as many vehicles [byte]."""


@dataclass(frozen=True, slots=True)
class Curve:
    """Points of a block, by rising number of vehicles."""

    block: str
    beside: str
    """Name of the reference."""
    points: tuple[Point, ...]

    @property
    def sizes(self) -> np.ndarray:
        """Return the numbers of vehicles, (k,)."""
        return np.array([float(one.vehicles) for one in self.points])

    @property
    def time_law(self) -> PowerLaw:
        """Return the power law of the time [s]."""
        return power_law(self.sizes, np.array([one.seconds for one in self.points]))

    @property
    def memory_law(self) -> PowerLaw:
        """Return the power law of the bytes held."""
        return power_law(self.sizes, np.array([float(one.held) for one in self.points]))


def measured_curves(sizes: Sequence[int], most_ticks: int = MOST_TICKS) -> list[Curve]:
    """Measure every block at every size."""
    found: dict[tuple[str, str], list[Point]] = {}
    for vehicles in sizes:
        ticks = min(most_ticks, max(LEAST_TICKS, min(MOST_TICKS, VEHICLE_TICKS // vehicles)))
        scene = scene_of(vehicles, ticks)
        for (block, beside), point in _points(scene).items():
            found.setdefault((block, beside), []).append(point)
    return [Curve(*names, tuple(points)) for names, points in found.items()]


def _points(scene: Scene) -> dict[tuple[str, str], Point]:
    blocks = timed_blocks(scene)
    for k in range(scene.timed.start):
        for block in blocks:
            block.task(k)
    parts = [part.tolist() for part in np.array_split(np.array(scene.timed), REPETITIONS)]
    spent = np.empty((REPETITIONS, len(blocks)))
    beside = np.empty((REPETITIONS, len(blocks)))
    for row, part in enumerate(parts):
        taken = np.array([[_seconds(block.task, k) for block in blocks] for k in part])
        spent[row] = np.median(taken, axis=0)
        beside[row] = [_reference(block, part) for block in blocks]
    vehicles, message = len(scene.scenario.names), len(encode(scene.ticks[0].state, 0))
    whole = [float(np.median([scene.seconds[k] for k in part])) for part in parts]
    found = {
        (block.name, block.beside): Point(
            vehicles, *_middle(spent[:, c]), float(np.median(beside[:, c])), array_bytes(block.keeps), message
        )
        for c, block in enumerate(blocks)
    }
    held = sum(point.held for (name, _), point in found.items() if name in IN_TICK)
    found[WHOLE, "10 ms"] = Point(vehicles, *_middle(np.array(whole)), TICK_S, held, message)
    return found


def _reference(block: TimedBlock, part: Sequence[int]) -> float:
    """Return the time of a reference for the block's job [s]."""
    return block.times * float(np.median([_seconds(block.reference, k) for k in part[:REFERENCE_TICKS]]))


def _middle(seconds: np.ndarray) -> tuple[float, float, float]:
    """Return median, least and most."""
    return float(np.median(seconds)), float(seconds.min()), float(seconds.max())


def _seconds(task: Task, k: int) -> float:
    start = process_time()
    task(k)
    return process_time() - start
