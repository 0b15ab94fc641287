"""Positions and deviation bases of a swarm at common sample times."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from q2q_model.signals.values import Array
from q2q_model.trajectory.polynomials import SwarmPlan, Trajectory
from q2q_planner.offline.avoidance.deviation_space import DeviationSpace

FINE = 512
"""Number of equally spaced times at which speeds are evaluated to choose the samples."""
FINE_PIECE = 4
"""Minimum number of intervals between such times in a piece."""
MOST_ROWS = 2**26
"""Most numbers of the deviation bases: half a gigabyte."""


@dataclass(frozen=True, slots=True, eq=False)
class SwarmSamples:
    """S sample times of n vehicles."""

    t: Array
    """[s], rising, (S,)."""
    base: Array
    """Positions of the undeformed curves [m], (S, n, 3)."""
    rows: Array
    """phi of each vehicle, zero-padded to the largest dimension, (n, S, m)."""

    def positions(self, deviations: Array) -> Array:
        """Return the positions [m], (S, n, 3), under deviations y (n, m, 3)."""
        return np.asarray(self.base + np.matmul(self.rows, deviations).swapaxes(0, 1))

    def with_room(self) -> "SwarmSamples":
        """Return the samples with one vehicle more, that stands for the room: at rest at the origin."""
        count, dimension = len(self.t), self.rows.shape[2]
        base = np.concatenate([self.base, np.zeros((count, 1, 3))], axis=1)
        return SwarmSamples(self.t, base, np.concatenate([self.rows, np.zeros((1, count, dimension))]))


def sample_swarm(plan: SwarmPlan, spaces: Sequence[DeviationSpace], t: Array) -> SwarmSamples:
    """Return the samples at times t (m,) [s]; vehicles are at rest after their end.

    Raises:
        ValueError: they do not fit in memory.
    """
    most = MOST_ROWS // (len(spaces) * max(1, *(space.dimension for space in spaces)))
    if len(t) > most:
        ways = f"the paths are too long for the radius of the zone: {len(t)} samples, maximum {most}"
        raise ValueError(f"{ways}; plan a part of the flight, or give a larger zone")
    rows = np.zeros((len(spaces), len(t), max(space.dimension for space in spaces)))
    for vehicle, space in enumerate(spaces):
        rows[vehicle, :, : space.dimension] = space.rows(t)
    return SwarmSamples(t, plan.positions(t), rows)


def sample_times(trajectories: Sequence[Trajectory], spacing: float, fewest: int) -> Array:
    """Return times (m,) [s] between which no pair moves apart or together by more than about `spacing` [m].

    The two fastest vehicles of each moment are assumed to fly head on; at least `fewest` samples.
    """
    end = max(trajectory.duration for trajectory in trajectories)
    fine = _fine_times(trajectories, end)
    speed = np.array([np.linalg.norm(one.at(fine, 1)[:, :3], axis=-1) for one in trajectories])
    fastest = np.partition(speed, -min(2, len(speed)), axis=0)[-2:].sum(axis=0)
    rate = fastest / spacing + fewest / end  # samples per second
    count = np.concatenate([[0.0], np.cumsum(0.5 * (rate[1:] + rate[:-1]) * np.diff(fine))])
    return np.asarray(np.interp(np.linspace(0.0, count[-1], int(np.ceil(count[-1])) + 1), count, fine))


def _fine_times(trajectories: Sequence[Trajectory], end: float) -> Array:
    """Return times (m,) [s] at which speeds are evaluated, some of them in every piece."""
    fine = np.linspace(0.0, end, FINE)
    durations = np.concatenate([one.durations for one in trajectories])
    starts = np.concatenate([np.cumsum(one.durations) - one.durations for one in trajectories])
    short = durations < FINE_PIECE * fine[1]
    if not short.any():
        return fine
    share = np.linspace(0.0, 1.0, FINE_PIECE + 1)
    more = starts[short, None] + durations[short, None] * share
    return np.unique(np.minimum(np.concatenate([fine, more.ravel()]), end))
