"""Memory of every vehicle's last solution, shifted to the time of the next tick.

Paths are stored relative to their references, so that a solution shifted beyond its end continues along the
reference. Inputs are stored as they are, the active set as the next solve's warm start.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from q2q_model.compiled import compiled
from q2q_model.signals.values import Array, Names, rows_by_name


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


PlainPrediction = tuple[float, Array, Array, NDArray[np.int8], Array]
"""Fields of a PredictedSolution, which numba takes from Python in less than half the time."""


class PreviousSolution:
    """Last solution by vehicle name."""

    def __init__(self, steps: int, step: float) -> None:
        """Store solutions of `steps` stages of `step` [s]."""
        self._step = step
        self._names: Names = ()
        self._solution = PredictedSolution(
            start=-np.inf,
            offset=np.zeros((0, steps + 1, 3)),
            inputs=np.zeros((0, steps, 3)),
            active_set=np.zeros((0, steps, 3), np.int8),
            solved=np.zeros(0),
        )

    def shifted(self, names: Names, start: float) -> PredictedSolution:
        """Return the solutions of `names` from `start` [s] on; a vehicle without one is on its reference."""
        if names != self._names:
            self._solution, self._names = _reordered(self._solution, self._names, names), names
        old = self._solution
        late = max((start - old.start) / self._step, 0.0) if math.isfinite(old.start) else 0.0
        new = PredictedSolution(
            start,
            np.empty(old.offset.shape),
            np.empty(old.inputs.shape),
            np.empty(old.active_set.shape, np.int8),
            old.solved,
        )
        _shift(late, (*old,), (*new,))
        return new

    def keep(self, names: Names, solution: PredictedSolution) -> None:
        """Remember the solutions of a tick."""
        self._names, self._solution = names, solution


def _reordered(old: PredictedSolution, have: Names, names: Names) -> PredictedSolution:
    """Return the rows of `names` of solutions of the vehicles `have`; a new one is on its reference."""
    return PredictedSolution(
        start=old.start,
        offset=rows_by_name(old.offset, have, names),
        inputs=rows_by_name(old.inputs, have, names),
        active_set=rows_by_name(old.active_set, have, names),
        solved=rows_by_name(old.solved, have, names, -np.inf),
    )


@compiled
def _shift(late: float, last: PlainPrediction, written: PlainPrediction) -> None:
    """Write a prediction as the `last`, `late` stages on.

    Offsets are interpolated, inputs held, active sets are the nearest.
    """
    old, new = PredictedSolution(*last), PredictedSolution(*written)
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
