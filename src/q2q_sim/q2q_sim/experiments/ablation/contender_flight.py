"""Flight of one contender in one case, with the metrics of every draw.

The closed loop is q2q_sim.loop's, with the contender as controller. Errors are true minus planned positions.

| column | meaning |
|---|---|
| flight | z RMSE of all vehicles over the flight [m] |
| lower | z RMSE of the first vehicle, the lowest, over the flight [m] |
| under | z RMSE of vehicles under another (q2q_sim.monitors.exposure) [m] |
| worst | largest |z error| in the same time [m] |
| clear | z RMSE of vehicles in clear air [m] |
| energy | int U1^2 dt of the first vehicle, above hover [N^2 s] |
"""

from dataclasses import dataclass, replace

import numpy as np

from q2q_model.downwash.jet import Jet
from q2q_model.signals.values import Array
from q2q_sim.air.room_air import RoomAir
from q2q_sim.experiments.ablation.ablation_cases import Case, scenario_of, side_by_side
from q2q_sim.experiments.ablation.contenders import CONTENDERS, Situation
from q2q_sim.loop.assembly import TICK_S, Blocks, Options, blocks_of, plan_of
from q2q_sim.loop.closed_loop import FlightOptions, fly_blocks
from q2q_sim.monitors.exposure import SETTLE, exposure
from q2q_sim.scenarios.scenario import Scenario

COLUMNS = ("flight", "lower", "under", "worst", "clear", "energy")


@dataclass(frozen=True, slots=True)
class Trace:
    """Measured quantities of a flight of n vehicles."""

    pos: Array
    """True positions [m], world, (T, n, 3)."""
    error: Array
    """True minus planned height [m], (T, n)."""
    thrust: Array
    """Commanded U1 [N], (T, n)."""


@dataclass(frozen=True, slots=True)
class ContenderFlight:
    """One flight of the ablation: draws side by side, all with one model and one seed."""

    case: Case
    contender: str
    model: Jet
    air: RoomAir
    seed: int
    draws: int


def fly_contender(asked: ContenderFlight) -> Array:
    """Return COLUMNS of every draw, (draws, 6)."""
    one, contender = scenario_of(asked.case), CONTENDERS[asked.contender]
    scenario = side_by_side(one, asked.draws)
    plan = plan_of(scenario)
    controller = contender.built(Situation(scenario, plan, asked.model))
    blocks = replace(blocks_of(scenario, Options(), asked.model, plan), controller=controller)
    options = FlightOptions("aware" if contender.aware else "ignoring", seed=asked.seed, air=asked.air)
    return measured(flown(scenario, blocks, options), len(one.names), one.vehicle.hover_thrust)


def flown(scenario: Scenario, blocks: Blocks, options: FlightOptions) -> Trace:
    """Return a flight of the blocks."""
    flight = fly_blocks(scenario, blocks, options)
    return Trace(flight.true_pos, flight.true_pos[..., 2] - flight.ref_pos[..., 2], flight.thrust)


def measured(trace: Trace, each: int, weight: float) -> Array:
    """Return COLUMNS of every draw of `each` vehicles, (draws, 6); NaN if none was under another.

    `weight` is m g [N].
    """
    ticks, n = trace.error.shape
    judged = np.arange(ticks) >= round(SETTLE / TICK_S)
    rows = []
    for start in range(0, n, each):
        own = slice(start, start + each)
        error, (under, clear) = trace.error[:, own], exposure(trace.pos[:, own], TICK_S)
        energy = float(np.sum(trace.thrust[:, start] ** 2 - weight**2)) * TICK_S
        worst = float(np.abs(error[under]).max()) if under.any() else np.nan
        flight = error[judged]
        rows.append([_rms(flight), _rms(flight[:, 0]), _rms(error[under]), worst, _rms(error[clear]), energy])
    return np.array(rows)


def _rms(error: Array) -> float:
    return float(np.sqrt(np.mean(error**2))) if error.size else float("nan")
