"""Commanded accelerations of one tick: from the solution, the last plan or a PD law.

| a vehicle's horizon | command | counted as |
|---|---|---|
| solved, or feasible though not optimal | its first input | solved, cut_off |
| not solved in time or not finite, up to shift_time after the last solve | its last plan, shifted | shifted |
| the same, later | PD law with the loop's bandwidths | pid |
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from q2q_control.mpc.mpc_params import MpcParams
from q2q_control.mpc.prediction.downwash_stages import Flags
from q2q_control.mpc.prediction.outlook import Outlook
from q2q_control.mpc.prediction.plan_memory import Plan
from q2q_control.mpc.problem.horizon import CUT_OFF, INTERRUPTED, Horizon, HorizonSolution
from q2q_model.compiled import compiled
from q2q_model.signals.values import Array

TICK = 0.01
"""Time that a command acts before the next one [s]: the 100 Hz tick."""


@dataclass(frozen=True, slots=True)
class MpcReport:
    """Number of vehicles by the source of their last command."""

    solved: int = 0
    cut_off: int = 0
    shifted: int = 0
    pid: int = 0
    iterations: int = 0
    """Most recursions of one problem."""
    pairs: int = 0
    """Pairs whose downwash matters on the horizon."""


@dataclass(frozen=True, slots=True)
class Commanded:
    """Commanded accelerations of one tick, and the plans behind them."""

    acc: Array
    """[m/s^2], world, (n, 3)."""
    plan: Plan
    report: MpcReport


def commanded(solution: HorizonSolution, horizon: Horizon, outlook: Outlook, params: MpcParams) -> Commanded:
    """Return each vehicle's commanded acceleration, the plan to remember, and the report."""
    plan, failed = outlook.plan, _failed(solution.inputs, solution.status)
    shifted = failed & (plan.start - plan.solved <= params.shift_time)
    by_pd = failed & ~shifted
    acc = solution.inputs[:, 0] + first_tick_lead(horizon, params.step)
    if shifted.any():
        acc = np.where(shifted[:, None], plan.inputs[:, 0], acc)
    if by_pd.any() or params.mode == "altitude":
        pd = pd_acceleration(horizon, params)
        acc = np.where(by_pd[:, None], pd, acc)
        if params.mode == "altitude":
            acc[:, :2] = pd[:, :2]
    report = MpcReport(
        solved=int(np.count_nonzero(~failed)),
        cut_off=int(np.count_nonzero(solution.status == CUT_OFF)),
        shifted=int(np.count_nonzero(shifted)),
        pid=int(np.count_nonzero(by_pd)),
        iterations=solution.iterations,
        pairs=len(outlook.downwash.i),
    )
    return Commanded(acc, _new_plan(solution, horizon, plan, failed), report)


@compiled
def _failed(inputs: Array, status: NDArray[np.int8]) -> Flags:
    """Return which vehicles were INTERRUPTED or have inputs (n, N, 3) that are not finite, (n,)."""
    failed = np.zeros(status.size, np.bool_)
    for v in range(status.size):
        failed[v] = status[v] == INTERRUPTED
        for value in inputs[v].flat:
            failed[v] = failed[v] or not np.isfinite(value)
    return failed


def first_tick_lead(horizon: Horizon, step: float) -> Array:
    """Return the correction of the first inputs, which act for a tick and not for a stage, (n, 3) [m/s^2].

    An input responds to the mean downwash and reference of its stage, half a stage ahead, but the command
    acts half a tick ahead. The difference is taken from the trend of u*.
    """
    early = 0.5 * max(step - TICK, 0.0) / step
    rise = horizon.reference[:, 1, 6:9] - horizon.reference[:, 0, 6:9]
    return np.asarray(early * (horizon.push[:, 1] - horizon.push[:, 0] - rise))


def pd_acceleration(horizon: Horizon, params: MpcParams) -> Array:
    """Return a PD law of the loop's bandwidths, less downwash and disturbance, (n, 3) [m/s^2]."""
    w = np.array([params.bandwidth_xy, params.bandwidth_xy, params.bandwidth_z])
    ref, now = horizon.reference[:, 0], horizon.start
    feedback = w**2 * (ref[:, :3] - now[..., 0]) + np.sqrt(2.0) * w * (ref[:, 3:6] - now[..., 1])
    return np.asarray(np.clip(ref[:, 6:9] + feedback - horizon.push[:, 0], horizon.low, horizon.high[:, 0]))


def _new_plan(solution: HorizonSolution, horizon: Horizon, old: Plan, failed: Flags) -> Plan:
    """Return the solution as a plan, the rows of failed vehicles from the old one."""
    offset, solved = solution.pos - horizon.reference[..., :3], np.full(len(failed), old.start)
    inputs, pattern = solution.inputs, solution.pattern
    if failed.any():
        row = failed[:, None, None]
        offset, solved = np.where(row, old.offset, offset), np.where(failed, old.solved, solved)
        inputs, pattern = np.where(row, old.inputs, inputs), np.where(row, old.pattern, pattern)
    return old._replace(offset=offset, inputs=inputs, pattern=pattern, solved=solved)
