"""Remember the last plan of every vehicle, and shift it to the time of the next tick.

Paths are kept as what they differ from their references, so that a plan shifted beyond its end goes on along
the reference. Inputs are kept as they are, the pattern of active bounds as the next solve's first guess.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from q2q_model.compiled import compiled
from q2q_model.signals.values import Array, Names, index_of


@dataclass(frozen=True, slots=True)
class Plan:
    """Predicted plans of a swarm from one tick; N stages of equal steps."""

    start: float
    """Time of the first stage [s]."""
    offset: Array
    """Predicted minus reference position [m], world, (n, N + 1, 3)."""
    inputs: Array
    """Commanded acceleration [m/s^2], world, (n, N, 3)."""
    pattern: NDArray[np.int8]
    """Active bounds (q2q_control.mpc.solver.riccati), (n, N, 3)."""
    solved: Array
    """Start of the plan that was really solved [s], (n,); minus infinity where there is none."""


class PlanMemory:
    """Last plan by vehicle name."""

    def __init__(self, steps: int, step: float) -> None:
        """Hold plans of `steps` stages of `step` [s]."""
        self._steps, self._step = steps, step
        self.reset()

    def reset(self) -> None:
        """Forget all plans."""
        self._names: Names = ()
        self._plan = self._blank(0)

    def shifted(self, names: Names, start: float) -> Plan:
        """Return the plans of `names` from `start` [s] on; a vehicle without one is on its reference."""
        if names != self._names:
            self._plan, self._names = self._reordered(index_of(names, self._names)), names
        plan = self._plan
        late = max((start - plan.start) / self._step, 0.0) if np.isfinite(plan.start) else 0.0
        offset, inputs = np.empty_like(plan.offset), np.empty_like(plan.inputs)
        pattern = np.empty_like(plan.pattern)
        _shift(late, (plan.offset, plan.inputs, plan.pattern), (offset, inputs, pattern))
        return Plan(start, offset, inputs, pattern, plan.solved)

    def keep(self, names: Names, plan: Plan) -> None:
        """Remember the plans of a tick."""
        self._names, self._plan = names, plan

    def _blank(self, n: int) -> Plan:
        return Plan(
            start=-np.inf,
            offset=np.zeros((n, self._steps + 1, 3)),
            inputs=np.zeros((n, self._steps, 3)),
            pattern=np.zeros((n, self._steps, 3), np.int8),
            solved=np.full(n, -np.inf),
        )

    def _reordered(self, rows: NDArray[np.intp]) -> Plan:
        old, blank = self._plan, self._blank(1)
        return Plan(
            start=old.start,
            offset=np.concatenate([old.offset, blank.offset])[rows],
            inputs=np.concatenate([old.inputs, blank.inputs])[rows],
            pattern=np.concatenate([old.pattern, blank.pattern])[rows],
            solved=np.concatenate([old.solved, blank.solved])[rows],
        )


@compiled
def _shift(
    late: float,
    old: tuple[Array, Array, NDArray[np.int8]],
    new: tuple[Array, Array, NDArray[np.int8]],
) -> None:
    """Fill `new` by `old`, `late` stages on: offsets along straight lines, inputs held, nearest patterns."""
    vehicles, stages = old[1].shape[0], old[1].shape[1]
    nearest = int(late + 0.5)
    for v in range(vehicles):
        for k in range(stages + 1):
            place = min(k + late, float(stages))
            before = min(int(place), stages - 1)
            share = place - before
            for axis in range(3):
                here, after = old[0][v, before, axis], old[0][v, before + 1, axis]
                new[0][v, k, axis] = here + share * (after - here)
                if k < stages:
                    new[1][v, k, axis] = old[1][v, before, axis]
                    new[2][v, k, axis] = old[2][v, min(k + nearest, stages - 1), axis]
