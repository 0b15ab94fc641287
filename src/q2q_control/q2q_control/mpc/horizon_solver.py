"""Solve one tick's horizon for all vehicles: groups, problems, answers.

Vehicles whose downwash matter to each other within the horizon form a group and are solved together, or each
by itself against the others' predicted paths. Axes that no downwash couples are swept all at once; of those,
the ones that meet a bound are solved one by one.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from q2q_control.mpc.chain import Chain
from q2q_control.mpc.group_solve import solve_group
from q2q_control.mpc.prediction.downwash_horizon import DownwashHorizon
from q2q_control.mpc.problem.horizon import CUT_OFF, INTERRUPTED, SOLVED, Horizon, HorizonSolution
from q2q_control.mpc.problem.joint_problem import GroupShape, group_shape
from q2q_control.mpc.solver.chain_sweep import sweep_free, sweep_gains
from q2q_model.compiled import compiled

Rows = NDArray[np.intp]
InTime = Callable[[], bool]


@dataclass(frozen=True, slots=True)
class SolveRules:
    """Parameters of the joint solution of interacting vehicles."""

    joint: bool
    """Together; else each by itself."""
    terminal: float
    """Weight beyond the horizon over the endless one [-]: the endless one knows no bounds."""
    iterations: int
    """Recursions of a solve at most."""


class Solver(Protocol):
    """Solver of one tick's problem."""

    def solve(
        self, horizon: Horizon, downwash: DownwashHorizon, guess: NDArray[np.int8], in_time: InTime
    ) -> HorizonSolution:
        """Return the answer."""


class HorizonSolver:
    """Axis models, and the structure shared by problems of equal shape."""

    def __init__(
        self,
        models: tuple[Chain, Chain, Chain],
        coupled: tuple[int, ...],
        stages: int,
        rules: SolveRules,
    ) -> None:
        """Solve with the chains of x, y, z; downwash couples the axes `coupled`.

        Args:
            models: x and y must be alike.
            coupled: axes whose inputs are found together with their downwash.
            stages: N.
            rules: how groups are solved.
        """
        self._models, self._coupled = models, coupled
        self._rules = rules
        self._stages = stages
        self._side, self._up = sweep_gains(models[0]), sweep_gains(models[2])
        self._shapes: dict[tuple[int, tuple[int, ...]], GroupShape] = {}

    def solve(
        self, horizon: Horizon, downwash: DownwashHorizon, guess: NDArray[np.int8], in_time: InTime
    ) -> HorizonSolution:
        """Return the answer; `guess` (n, N, 3) is a pattern of active bounds to start from.

        `in_time` is asked before each problem that needs more than the sweep; False leaves it INTERRUPTED.
        """
        n, stages = horizon.push.shape[:2]
        answer = HorizonSolution(
            pos=np.empty((n, stages + 1, 3)),
            inputs=np.empty((n, stages, 3)),
            pattern=np.zeros((n, stages, 3), np.int8),
            ended=np.full(n, SOLVED, np.int8),
            iterations=1,
        )
        groups = groups_of(downwash.i, downwash.j, n, joint=self._rules.joint)
        problems = [(group, self._coupled) for group in groups]
        problems += self._swept(horizon, answer, [vehicle for group in groups for vehicle in group])
        most = 1
        for group, axes in problems:
            most = max(most, self._solve(horizon, downwash, (group, axes), (guess, answer, in_time)))
        return HorizonSolution(answer.pos, answer.inputs, answer.pattern, answer.ended, most)

    def _swept(
        self, horizon: Horizon, answer: HorizonSolution, grouped: list[int]
    ) -> list[tuple[list[int], tuple[int, ...]]]:
        """Sweep all chains that no downwash couples; return those that cross a bound, each by itself."""
        free = np.ones((len(answer.ended), 3), np.bool_)
        for axis in self._coupled if grouped else ():
            free[grouped, axis] = False
        crossing = sweep_free(horizon, free, (self._side, self._up), (answer.pos, answer.inputs))
        if not crossing.any():
            return []
        return [([int(v)], (int(axis),)) for v, axis in np.argwhere(crossing)]

    def _solve(
        self,
        horizon: Horizon,
        downwash: DownwashHorizon,
        chains: tuple[list[int], tuple[int, ...]],
        io: tuple[NDArray[np.int8], HorizonSolution, InTime],
    ) -> int:
        """Solve the chains `axes` of a group into the answer; return the recursions it took."""
        guess, answer, in_time = io
        group = np.array(chains[0])
        if not in_time():
            answer.ended[group] = INTERRUPTED
            return 0
        used, converged, finite = solve_group(
            (self._shape(group.size, chains[1]), group),
            horizon,
            (downwash.i, downwash.j, downwash.slope),
            (guess, answer.pos, answer.inputs, answer.pattern),
            self._rules.iterations,
        )
        if not finite:
            answer.ended[group] = INTERRUPTED
        elif not converged:
            answer.ended[group] = np.where(answer.ended[group] == SOLVED, CUT_OFF, answer.ended[group])
        return int(used)

    def _shape(self, size: int, axes: tuple[int, ...]) -> GroupShape:
        key = (size, axes)
        if key not in self._shapes:
            shape = group_shape(size, axes, self._models, self._stages)
            self._shapes[key] = shape._replace(terminal=self._rules.terminal * shape.terminal)
        return self._shapes[key]


def groups_of(i: Rows, j: Rows, n: int, *, joint: bool) -> list[list[int]]:
    """Return the vehicles below `n` that feel downwash, those that pairs join together where `joint`."""
    roots: dict[int, list[int]] = {}
    for vehicle, root in enumerate(_roots(i, j, n, joint).tolist()):
        if root >= 0:
            roots.setdefault(root, []).append(vehicle)
    return list(roots.values())


@compiled
def _roots(i: Rows, j: Rows, n: int, joint: bool) -> Rows:
    """Return the first vehicle of each vehicle's group, -1 for those in none, (n,)."""
    root = np.full(n, -1)
    for pair in range(i.size):
        if i[pair] < n:
            root[i[pair]] = i[pair]
    if not joint:
        return root
    for pair in range(i.size):
        a, b = i[pair], j[pair]
        if a >= n or b >= n:
            continue
        old, new = root[a], root[b] if root[b] >= 0 else b
        root[b] = new
        low, high = min(old, new), max(old, new)
        for v in range(n):
            if root[v] == high:
                root[v] = low
    return root
