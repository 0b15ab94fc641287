"""Memory of every vehicle's last solution, shifted to the time of the next tick.

Paths are stored relative to their references, so that a solution shifted beyond its end continues along the
reference. Inputs are stored as they are, the active set as the next solve's warm start.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from q2q_model.compiled import compiled
from q2q_model.signals.values import Array, Names, index_of


class PredictedSolution(NamedTuple):
    """Solution for a swarm at one tick, as predicted motion; N stages of equal steps."""

    start: float
    """Time of the first stage [s]."""
    offset: Array
    """Predicted minus reference position [m], world, (n, N + 1, 3)."""
    inputs: Array
    """Commanded acceleration [m/s^2], world, (n, N, 3)."""
    active_set: NDArray[np.int8]
    """Active bounds (q2q_control.mpc.solver.active_set), (n, N, 3)."""
    solved: Array
    """Start of the solution as it was solved, before any shift [s], (n,); minus infinity if there is none."""


class PreviousSolution:
    """Last solution by vehicle name."""

    def __init__(self, steps: int, step: float) -> None:
        """Store solutions of `steps` stages of `step` [s]."""
        self._steps, self._step = steps, step
        self.reset()

    def reset(self) -> None:
        """Forget all solutions."""
        self._names: Names = ()
        self._solution = self._blank(0)

    def shifted(self, names: Names, start: float) -> PredictedSolution:
        """Return the solutions of `names` from `start` [s] on; a vehicle without one is on its reference."""
        if names != self._names:
            self._solution, self._names = self._reordered(index_of(names, self._names)), names
        old = self._solution
        late = max((start - old.start) / self._step, 0.0) if math.isfinite(old.start) else 0.0
        new = PredictedSolution(
            start,
            np.empty_like(old.offset),
            np.empty_like(old.inputs),
            np.empty_like(old.active_set),
            old.solved,
        )
        _shift(late, old, new)
        return new

    def keep(self, names: Names, solution: PredictedSolution) -> None:
        """Remember the solutions of a tick."""
        self._names, self._solution = names, solution

    def _blank(self, n: int) -> PredictedSolution:
        return PredictedSolution(
            start=-np.inf,
            offset=np.zeros((n, self._steps + 1, 3)),
            inputs=np.zeros((n, self._steps, 3)),
            active_set=np.zeros((n, self._steps, 3), np.int8),
            solved=np.full(n, -np.inf),
        )

    def _reordered(self, rows: NDArray[np.intp]) -> PredictedSolution:
        old, blank = self._solution, self._blank(1)
        return PredictedSolution(
            start=old.start,
            offset=np.concatenate([old.offset, blank.offset])[rows],
            inputs=np.concatenate([old.inputs, blank.inputs])[rows],
            active_set=np.concatenate([old.active_set, blank.active_set])[rows],
            solved=np.concatenate([old.solved, blank.solved])[rows],
        )


@compiled
def _shift(late: float, old: PredictedSolution, new: PredictedSolution) -> None:
    """Write `new` as `old`, `late` stages on: offsets interpolated, inputs held, the nearest active set."""
    vehicles, stages = old.inputs.shape[0], old.inputs.shape[1]
    nearest = int(late + 0.5)
    for v in range(vehicles):
        for k in range(stages + 1):
            place = min(k + late, float(stages))
            before = min(int(place), stages - 1)
            share = place - before
            for axis in range(3):
                here, after = old.offset[v, before, axis], old.offset[v, before + 1, axis]
                new.offset[v, k, axis] = here + share * (after - here)
                if k < stages:
                    new.inputs[v, k, axis] = old.inputs[v, before, axis]
                    new.active_set[v, k, axis] = old.active_set[v, min(k + nearest, stages - 1), axis]
