"""Flight of one contender in one case, with the metrics of every replica.

The closed loop is q2q_sim.loop's, with the contender as controller. Errors are true minus planned positions.

| column | meaning |
|---|---|
| flight | z RMSE of all vehicles over the flight [m] |
| lower | z RMSE of the first vehicle, the lowest, over the flight [m] |
| under | z RMSE of vehicles while under another, and for AFTER seconds after it [m] |
| worst | largest |z error| in the same time [m] |
| clear | z RMSE of vehicles that have not been under another for FORGOTTEN seconds [m] |
| energy | int U1^2 dt of the first vehicle, above hover [N^2 s] |
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from q2q_model.signals.values import Array
from q2q_sim.experiments.ablation.ablation_cases import Case, is_random, scenario_of, side_by_side
from q2q_sim.experiments.ablation.contenders import BLIND, built
from q2q_sim.experiments.ablation.learned_model import Learned
from q2q_sim.loop.assembly import TICK_S, Blocks, Options, blocks_of, plan_of
from q2q_sim.loop.closed_loop import FlightOptions, fly_blocks
from q2q_sim.scenarios.scenario import Scenario

COLUMNS = ("flight", "lower", "under", "worst", "clear", "energy")
SETTLE = 3.0
"""Initial transient that is not measured [s]."""
ASIDE = 0.15
"""Radius of the downwash [m] (real flights)."""
BELOW = 1.5
"""Length of the downwash that counts [m]."""
AFTER = 1.0
"""Time after a pass in which its error counts [s]."""
FORGOTTEN = 3.0
"""Time after which the air counts as clear again [s]."""


@dataclass(frozen=True, slots=True)
class Trace:
    """Measured quantities of a flight of n vehicles."""

    pos: Array
    """True positions [m], world, (T, n, 3)."""
    error: Array
    """True minus planned height [m], (T, n)."""
    thrust: Array
    """Commanded U1 [N], (T, n)."""


def trial(case: Case, contender: str, learned: Learned, count: int) -> Array:
    """Return COLUMNS of every replica, (count, 6); one row without randomness."""
    one = scenario_of(case)
    replicas = count if is_random(one) else 1
    scenario = side_by_side(one, replicas)
    plan = plan_of(scenario)
    controller = built(contender, (scenario, plan), learned, limited=case.limited)
    blocks = replace(blocks_of(scenario, Options(), learned.model, plan), controller=controller)
    trace = flown(scenario, blocks, aware=contender not in BLIND)
    return measured(trace, len(one.names), one.vehicle.hover_thrust)


def flown(scenario: Scenario, blocks: Blocks, *, aware: bool) -> Trace:
    """Return a flight of the blocks."""
    flight = fly_blocks(scenario, blocks, FlightOptions("aware" if aware else "ignoring"))
    return Trace(flight.true_pos, flight.true_pos[..., 2] - flight.ref_pos[..., 2], flight.thrust)


def measured(trace: Trace, each: int, weight: float) -> Array:
    """Return COLUMNS of every replica of `each` vehicles, (replicas, 6); NaN if none was under another.

    `weight` is m g [N].
    """
    ticks, n = trace.error.shape
    judged = np.arange(ticks) >= round(SETTLE / TICK_S)
    rows = []
    for start in range(0, n, each):
        own = slice(start, start + each)
        error, pos = trace.error[judged, own], trace.pos[:, own]
        under, clear = exposed(pos, AFTER)[judged], ~exposed(pos, FORGOTTEN)[judged]
        energy = float(np.sum(trace.thrust[:, start] ** 2 - weight**2)) * TICK_S
        worst = float(np.abs(error[under]).max()) if under.any() else np.nan
        rows.append([_rms(error), _rms(error[:, 0]), _rms(error[under]), worst, _rms(error[clear]), energy])
    return np.array(rows)


def exposed(pos: Array, after: float) -> NDArray[np.bool_]:
    """Return which vehicles are under another or were `after` [s] before, (T, n), of positions (T, n, 3)."""
    rel = pos[:, None] - pos[:, :, None]  # [t, i, j] = r_j - r_i
    near = (np.hypot(rel[..., 0], rel[..., 1]) < ASIDE) & (rel[..., 2] > 0.0) & (rel[..., 2] < BELOW)
    now = near.any(axis=2)
    last = np.maximum.accumulate(np.where(now, np.arange(len(pos))[:, None], -len(pos)), axis=0)
    return np.asarray(np.arange(len(pos))[:, None] - last <= round(after / TICK_S))


def _rms(error: Array) -> float:
    return float(np.sqrt(np.mean(error**2))) if error.size else float("nan")
