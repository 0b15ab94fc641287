"""Commanded accelerations of one tick: from the solution, the last one or a PD law.

| a vehicle's horizon | command | counted as |
|---|---|---|
| solved, or feasible though not optimal | its first input | solved |
| not in time or not finite, up to shift_time after the last solve | its last solution, shifted | shifted |
| the same, later | PD law with the loop's bandwidths | pd |
"""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from q2q_control.mpc.prediction.forecast import Forecast
from q2q_control.mpc.prediction.previous_solution import PlainPrediction, PredictedSolution
from q2q_control.mpc.problem.horizon import INTERRUPTED, Horizon, HorizonSolution, PlainHorizon, PlainSolution
from q2q_control.mpc.problem.mpc_params import MpcParams
from q2q_model.compiled import compiled
from q2q_model.signals.stamps import TICK_S
from q2q_model.signals.values import Array


class CommandSources(NamedTuple):
    """Number of vehicles by the source of their command."""

    solved: int = 0
    shifted: int = 0
    pd: int = 0


@dataclass(frozen=True, slots=True)
class MpcReport:
    """Solution of one tick in numbers."""

    sources: CommandSources = field(default_factory=CommandSources)
    iterations: int = 0
    """Most recursions of one problem."""
    pairs: int = 0
    """Pairs whose downwash matters on the horizon."""


@dataclass(frozen=True, slots=True)
class Commanded:
    """Commanded accelerations of one tick, and the motion predicted with them."""

    acc: Array
    """[m/s^2], world, (n, 3)."""
    predicted: PredictedSolution
    report: MpcReport


class CommandRule(NamedTuple):
    """Parameters of a command."""

    step: float
    """Length of a stage [s]."""
    shift_time: float
    """[s]"""
    bandwidth_xy: float
    """Of the PD law [rad/s]."""
    bandwidth_z: float
    """Of the PD law [rad/s]."""
    altitude_only: bool
    """Command x and y by the PD law."""


PlainRule = tuple[float, float, float, float, bool]
"""Fields of a CommandRule, which numba takes from Python in less than half the time."""


def plain_command_rule(params: MpcParams) -> PlainRule:
    """Return the parameters of the commands."""
    return (
        *CommandRule(
            step=params.step,
            shift_time=params.shift_time,
            bandwidth_xy=params.bandwidth_xy,
            bandwidth_z=params.bandwidth_z,
            altitude_only=params.axes == "altitude",
        ),
    )


def commanded_acceleration(
    solution: HorizonSolution, horizon: Horizon, forecast: Forecast, rule: PlainRule
) -> Commanded:
    """Return each vehicle's commanded acceleration, the solution to remember, and the report.

    Rows of `solution` that failed are overwritten by the last solution.
    """
    old, acc = forecast.previous, np.empty((len(solution.status), 3))
    offset, solved = np.empty(old.offset.shape), np.empty(old.solved.shape)
    new = PredictedSolution(old.start, offset, solution.inputs, solution.active_set, solved)
    shifted, pd = _choose((*solution,), (*horizon,), ((*old,), (*new,)), rule, acc)
    sources = CommandSources(len(acc) - shifted - pd, shifted, pd)
    report = MpcReport(sources, solution.iterations, len(forecast.downwash.i))
    return Commanded(acc, new, report)


@compiled
def _choose(
    found: PlainSolution,
    problem: PlainHorizon,
    predictions: tuple[PlainPrediction, PlainPrediction],
    parameters: PlainRule,
    acc: Array,
) -> tuple[int, int]:
    """Write the commands (n, 3) and the second prediction, the first one where a vehicle failed.

    Returns:
        Number of vehicles that follow their last solution, and that follow the PD law.
    """
    solution, horizon, rule = HorizonSolution(*found), Horizon(*problem), CommandRule(*parameters)
    old, new = PredictedSolution(*predictions[0]), PredictedSolution(*predictions[1])
    shifts = old.start - old.solved <= rule.shift_time
    shifted = pd = 0
    for v in range(acc.shape[0]):
        failed = _failed(solution, v)
        by_pd = failed and not shifts[v]
        for axis in range(3):
            acc[v, axis] = solution.inputs[v, 0, axis] + first_tick_lead(horizon, rule.step, v, axis)
            if failed:
                acc[v, axis] = old.inputs[v, 0, axis]
            if by_pd or (rule.altitude_only and axis < 2):
                bandwidth = rule.bandwidth_xy if axis < 2 else rule.bandwidth_z
                acc[v, axis] = pd_acceleration(horizon, bandwidth, v, axis)
        _keep_solution(solution, horizon, (old, new), v, failed)
        shifted += failed and not by_pd
        pd += by_pd
    return shifted, pd


@compiled
def _failed(solution: HorizonSolution, v: int) -> bool:
    """Return whether a vehicle was INTERRUPTED or has inputs that are not finite."""
    failed = solution.status[v] == INTERRUPTED
    for value in solution.inputs[v].flat:
        failed = failed or not np.isfinite(value)
    return bool(failed)


@compiled
def _keep_solution(
    solution: HorizonSolution,
    horizon: Horizon,
    predicted: tuple[PredictedSolution, PredictedSolution],
    v: int,
    failed: bool,
) -> None:
    """Write a vehicle's row of the second prediction: the solution, or the first prediction if it failed."""
    old, new = predicted
    new.solved[v] = old.solved[v] if failed else old.start
    if failed:
        new.offset[v], new.inputs[v], new.active_set[v] = old.offset[v], old.inputs[v], old.active_set[v]
        return
    for k in range(new.offset.shape[1]):
        for axis in range(3):
            new.offset[v, k, axis] = solution.pos[v, k, axis] - horizon.reference[v, k, axis]


@compiled
def first_tick_lead(horizon: Horizon, step: float, v: int, axis: int) -> float:
    """Return the correction of a first input, which acts for a tick and not for a stage [m/s^2].

    An input responds to the mean downwash and reference of its stage, half a stage ahead, but the command
    acts half a tick ahead. The difference is taken from the trend of u*. `v` and `axis` say whose input, and
    `step` is the length of a stage [s].
    """
    early = 0.5 * max(step - TICK_S, 0.0) / step
    rise = horizon.reference[v, 1, 6 + axis] - horizon.reference[v, 0, 6 + axis]
    return float(early * (horizon.push[v, 1, axis] - horizon.push[v, 0, axis] - rise))


@compiled
def pd_acceleration(horizon: Horizon, bandwidth: float, v: int, axis: int) -> float:
    """Return a PD law of the loop's bandwidth [rad/s], less downwash and disturbance, in bounds [m/s^2].

    `v` and `axis` are as above.
    """
    ref, now = horizon.reference[v, 0], horizon.start[v, axis]
    feedback = bandwidth**2 * (ref[axis] - now[0]) + np.sqrt(2.0) * bandwidth * (ref[3 + axis] - now[1])
    wanted = ref[6 + axis] + feedback - horizon.push[v, 0, axis]
    return float(min(max(wanted, horizon.low[v, axis]), horizon.high[v, 0, axis]))
