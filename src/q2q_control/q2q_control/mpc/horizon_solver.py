"""Solver of one tick's horizon for all vehicles: groups, their problems, the solution.

Vehicles whose downwash couples them within the horizon form a group and are solved together, or each by
itself against the others' predicted paths. Axes that no downwash couples are swept all at once; those of them
that meet a bound are solved one by one.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from q2q_control.mpc.chain import Chains, axis_chains
from q2q_control.mpc.group_solve import Group, Modes, solve_group
from q2q_control.mpc.mpc_params import MpcParams
from q2q_control.mpc.prediction.downwash_stages import DownwashHorizon
from q2q_control.mpc.problem.horizon import (
    CUT_OFF,
    INTERRUPTED,
    SOLVED,
    Horizon,
    HorizonSolution,
    blank_solution,
)
from q2q_control.mpc.problem.joint_problem import GroupShape, group_shape
from q2q_control.mpc.solver.chain_sweep import sweep_free, sweep_gains
from q2q_model.compiled import compiled
from q2q_model.vehicle.constants import Vehicle

Rows = NDArray[np.intp]
InTime = Callable[[], bool]


@dataclass(frozen=True, slots=True)
class SolveRules:
    """Parameters of the joint solution of interacting vehicles."""

    coupled: tuple[int, ...]
    """Axes whose inputs are solved together with their downwash."""
    joint: bool
    """Solve interacting vehicles together, not one by one."""
    terminal: float
    """Terminal weight over that of the infinite horizon [-]: the latter knows no bounds."""
    iterations: int
    """Most recursions of a solve."""


class Solver(Protocol):
    """Solver of one tick's problem."""

    def solve(
        self, horizon: Horizon, downwash: DownwashHorizon, guess: Modes, in_time: InTime
    ) -> HorizonSolution:
        """Return the solution."""


class HorizonSolver:
    """Axis models, and the structure shared by problems of equal shape."""

    def __init__(self, models: Chains, stages: int, rules: SolveRules) -> None:
        """Solve N = `stages` stages with the chains of x, y (which must be alike) and z."""
        self._models, self._stages, self._rules = models, stages, rules
        self._gains = sweep_gains(models[0]), sweep_gains(models[2])
        self._shapes: dict[tuple[int, tuple[int, ...]], GroupShape] = {}

    def solve(
        self, horizon: Horizon, downwash: DownwashHorizon, guess: Modes, in_time: InTime
    ) -> HorizonSolution:
        """Return the solution; `guess` (n, N, 3) is a pattern of active bounds to start from.

        `in_time` is called before each problem that the sweep does not solve; False leaves it INTERRUPTED.
        """
        solution = blank_solution(*horizon.push.shape[:2])
        coupled = groups_of(downwash.i, downwash.j, len(horizon.push), joint=self._rules.joint)
        groups = [self._group(vehicles, self._rules.coupled) for vehicles in coupled]
        groups += self._swept(horizon, solution, [vehicle for group in coupled for vehicle in group])
        most, status = 1, solution.status
        for group in groups:
            rows = group.vehicles
            if not in_time():
                status[rows] = INTERRUPTED
                continue
            result = solve_group(group, horizon, downwash, guess, solution)
            most = max(most, int(result.iterations))
            if not result.finite:
                status[rows] = INTERRUPTED
            elif not result.converged:
                status[rows] = np.where(status[rows] == SOLVED, CUT_OFF, status[rows])
        return solution._replace(iterations=most)

    def _swept(self, horizon: Horizon, solution: HorizonSolution, grouped: list[int]) -> list[Group]:
        """Sweep all chains that no downwash couples; return those that cross a bound, each by itself."""
        free = np.ones((len(solution.status), 3), np.bool_)
        for axis in self._rules.coupled if grouped else ():
            free[grouped, axis] = False
        crossing = sweep_free(horizon, free, self._gains, solution)
        if not crossing.any():
            return []
        return [self._group([int(v)], (int(axis),)) for v, axis in np.argwhere(crossing)]

    def _group(self, vehicles: list[int], axes: tuple[int, ...]) -> Group:
        key = (len(vehicles), axes)
        if key not in self._shapes:
            shape = group_shape(len(vehicles), axes, self._models, self._stages)
            self._shapes[key] = shape._replace(terminal=self._rules.terminal * shape.terminal)
        return Group(self._shapes[key], np.array(vehicles), self._rules.iterations)


def horizon_solver(params: MpcParams, vehicle: Vehicle) -> HorizonSolver:
    """Return the solver of (26) for vehicles like `vehicle`."""
    rules = SolveRules(coupled_axes(params), params.joint, params.terminal, params.iterations)
    return HorizonSolver(axis_chains(params, vehicle), params.steps, rules)


def coupled_axes(params: MpcParams) -> tuple[int, ...]:
    """Return the axes that downwash couples, of 0 1 2: x y z."""
    return (0, 1, 2) if params.mode == "full" else (2,)


def groups_of(i: Rows, j: Rows, n: int, *, joint: bool) -> list[list[int]]:
    """Return the vehicles below `n` that feel downwash, in groups connected by pairs if `joint`."""
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
