"""Solver of one tick's horizon for all vehicles: groups, their problems, the solution.

Vehicles whose downwash couples them within the horizon are solved together, in groups of at most `group_max`
vehicles: those that couple the most are joined first, and a group is solved against the predicted paths of
all others. A joint solve grows with the third power of its vehicles. Axes that no downwash couples are swept
all at once; those of them that meet a bound are solved one by one.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from q2q_control.mpc.problem.axis_model import AxisModels, axis_models
from q2q_control.mpc.problem.horizon import (
    INTERRUPTED,
    DownwashHorizon,
    Horizon,
    HorizonSolution,
    PlainDownwash,
    PlainHorizon,
    PlainSolution,
    blank_solution,
)
from q2q_control.mpc.problem.joint_problem import PlainShape, group_shape
from q2q_control.mpc.problem.mpc_params import MpcParams
from q2q_control.mpc.solver.active_set import ActiveSet
from q2q_control.mpc.solver.axis_sweep import sweep_axes, sweep_tables
from q2q_control.mpc.solver.group_solve import Group, solve_group
from q2q_model.compiled import compiled
from q2q_model.signals.values import Array, Mask, Rows
from q2q_model.vehicle.constants import Vehicle

InTime = Callable[[], bool]


@dataclass(frozen=True, slots=True)
class SolveRules:
    """Parameters of the joint solution of interacting vehicles."""

    coupled: tuple[int, ...]
    """Axes whose inputs are solved together with their downwash."""
    group_max: int
    """Most vehicles that are solved together."""
    terminal_weight: float
    """Terminal weight over that of the infinite horizon [-]: the latter knows no bounds."""
    iterations_max: int
    """Most recursions of a solve."""


class Solver(Protocol):
    """Solver of one tick's problem."""

    def solve(
        self, horizon: Horizon, downwash: DownwashHorizon, warm_start: ActiveSet, in_time: InTime
    ) -> HorizonSolution:
        """Return the solution."""


class HorizonSolver:
    """Axis models, and the structure shared by problems of equal shape."""

    def __init__(self, models: AxisModels, rules: SolveRules) -> None:
        """Solve with the models of x, y (which must be alike) and z."""
        self._models, self._rules = models, rules
        self._coupling = np.isin(range(3), rules.coupled), rules.group_max
        self._gains = sweep_tables(models)
        self._shapes: dict[tuple[int, tuple[int, ...]], PlainShape] = {}

    def solve(
        self, horizon: Horizon, downwash: DownwashHorizon, warm_start: ActiveSet, in_time: InTime
    ) -> HorizonSolution:
        """Return the solution; `warm_start` (n, N, 3) is the active set to start from.

        `in_time` is called before each problem that the sweep does not solve; False leaves it INTERRUPTED.
        """
        solution = blank_solution(*horizon.push.shape[:2])
        tick = (*horizon,), (*downwash,), (*solution,)
        most, status = 1, solution.status
        for group in self._swept(*tick):
            if not in_time():
                status[group.vehicles] = INTERRUPTED
                continue
            used, finite = solve_group((*group,), warm_start, *tick)
            most = max(most, used)
            if not finite:
                status[group.vehicles] = INTERRUPTED
        return solution._replace(iterations=most)

    def _swept(self, horizon: PlainHorizon, downwash: PlainDownwash, solution: PlainSolution) -> list[Group]:
        """Sweep all axes that no downwash couples; return the groups, then axes that cross a bound."""
        root, crossing = _group_and_sweep(horizon, downwash, self._coupling, self._gains, solution)
        groups = [self._group(vehicles, self._rules.coupled) for vehicles in groups_of(root)]
        if np.count_nonzero(crossing):
            groups += [self._group([int(v)], (int(axis),)) for v, axis in np.argwhere(crossing)]
        return groups

    def _group(self, vehicles: list[int], axes: tuple[int, ...]) -> Group:
        key = (len(vehicles), axes)
        if key not in self._shapes:
            shape = group_shape(len(vehicles), axes, self._models, self._rules.terminal_weight)
            self._shapes[key] = (*shape,)
        return Group(self._shapes[key], np.array(vehicles), self._rules.iterations_max)


def horizon_solver(params: MpcParams, vehicle: Vehicle) -> HorizonSolver:
    """Return the solver of (26) for vehicles like `vehicle`."""
    rules = SolveRules(coupled_axes(params), params.group_max, params.terminal_weight, params.iterations_max)
    return HorizonSolver(axis_models(params, vehicle), rules)


def coupled_axes(params: MpcParams) -> tuple[int, ...]:
    """Return the axes that downwash couples, of 0 1 2: x y z."""
    return (0, 1, 2) if params.axes == "coupled_xyz" else (2,)


def groups_of(root: Rows) -> list[list[int]]:
    """Return the vehicles of each group; `root` (n,) is that of `group_roots`."""
    groups: dict[int, list[int]] = {}
    for vehicle, first in enumerate(root.tolist()):
        if first >= 0:
            groups.setdefault(first, []).append(vehicle)
    return list(groups.values())


@compiled
def _group_and_sweep(
    horizon: PlainHorizon,
    downwash: PlainDownwash,
    coupling: tuple[Mask, int],
    gains: Array,
    solution: PlainSolution,
) -> tuple[Rows, Mask]:
    """Write the axes that no downwash couples; return the roots of groups and who crosses a bound, (n, 3).

    `coupling` are the axes that downwash couples, (3,), and the most vehicles of a group; `gains` are tables,
    as `sweep_tables`.
    """
    (axes, most), out = coupling, HorizonSolution(*solution)
    root = group_roots(DownwashHorizon(*downwash), out.status.size, most)
    free = np.ones((root.size, 3), np.bool_)
    for v in range(root.size):
        for axis in range(3):
            free[v, axis] = root[v] < 0 or not axes[axis]
    return root, sweep_axes(Horizon(*horizon), free, gains, out)


@compiled
def group_roots(downwash: DownwashHorizon, n: int, most: int) -> Rows:
    """Return the first vehicle of each vehicle's group, -1 for those in none, (n,).

    Grouped are the vehicles below `n` that feel downwash, with those that cause it, at most `most` a group.
    """
    root, size = np.full(n, -1), np.ones(n, np.intp)
    for i in downwash.i:
        if i < n:
            root[i] = i
    for pair in np.argsort(-_couplings(downwash)):
        i, j = downwash.i[pair], downwash.j[pair]
        if i < n and j < n:
            _join_groups(root, size, (i, j), most)
    return root


@compiled
def _couplings(downwash: DownwashHorizon) -> Array:
    """Return the coupling of each pair: the sum of the absolute gradients over the horizon."""
    coupling = np.zeros(downwash.i.size)
    for pair in range(downwash.i.size):
        coupling[pair] = np.abs(downwash.gradient[pair]).sum()
    return coupling


@compiled
def _join_groups(root: Rows, size: Rows, pair: tuple[int, int], most: int) -> None:
    """Join the groups of i, which feels downwash, and j; not beyond `most` vehicles.

    `root` is that of `group_roots`, (n,); `size` are the vehicles of the group of each root, (n,).
    """
    i, j = pair
    one, other = root[i], root[j] if root[j] >= 0 else j
    if one == other or size[one] + size[other] > most:
        return
    root[j] = other
    low, high = min(one, other), max(one, other)
    size[low] += size[high]
    for v in range(root.size):
        if root[v] == high:
            root[v] = low
