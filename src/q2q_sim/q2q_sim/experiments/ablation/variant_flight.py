"""Flight of one variant of the controller in one case, with the height errors of every draw.

The closed loop is q2q_sim.loop's. Errors are true minus planned heights.

| column | meaning |
|---|---|
| under | z RMSE of vehicles under another (q2q_sim.monitors.metrics.exposure) [m] |
| clear | z RMSE of vehicles in clear air [m] |
| worst | largest |z error| of vehicles under another [m] |
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from q2q_model.downwash.no_interaction import NoInteraction
from q2q_model.signals.stamps import TICK_S
from q2q_model.signals.values import Array
from q2q_sim.air.lookup.find_air import FlownAir
from q2q_sim.experiments.ablation.ablation_cases import Case, scenarios_of
from q2q_sim.experiments.ablation.learned_models import LearnedModel
from q2q_sim.experiments.ablation.model_groups import GroupedController, ModelGroup
from q2q_sim.experiments.ablation.onboard_flight import Trace, fly_on_board
from q2q_sim.experiments.ablation.side_by_side import side_by_side, with_vehicles
from q2q_sim.experiments.ablation.variants import ONBOARD, VARIANTS, Variant, VariantInputs
from q2q_sim.loop.closed_loop import LoopSettings, fly_blocks
from q2q_sim.loop.flight_blocks import BlockChoices, Mode, blocks_of
from q2q_sim.monitors.metrics.exposure import exposure
from q2q_sim.monitors.metrics.flight_metrics import largest, rms
from q2q_sim.scenarios.scenario import Scenario

COLUMNS = ("under", "clear", "worst")
SEED = 19
"""Of all flights: another one than those that controllers were designed on (0)."""


@dataclass(frozen=True, slots=True)
class VariantFlight:
    """One flight of the ablation: draws side by side, draw k with model k mod len(models)."""

    case: Case
    variant: str
    models: tuple[LearnedModel, ...]
    air: FlownAir
    draws: int


def fly_variant(asked: VariantFlight) -> Array:
    """Return COLUMNS of every draw, (draws, 3), draw k of path f in row k * paths + f."""
    apart = scenarios_of(asked.case.name)
    each = len(apart[0].names)
    scenario = side_by_side(apart, asked.draws)
    places = np.arange(len(scenario.names)) // each
    group = places // len(apart) % len(asked.models)
    if asked.variant in ONBOARD:
        models = [asked.models[k] for k in group]
        trace = fly_on_board(scenario, models, asked.air, SEED, apps=ONBOARD[asked.variant])
        return draw_columns(trace, each)
    inputs = [
        VariantInputs(
            with_vehicles(scenario, tuple(np.array(scenario.names)[group == k].tolist())), model, each
        )
        for k, model in enumerate(asked.models)
    ]
    rows = [np.flatnonzero(group == k) for k in range(len(asked.models))]
    variant = VARIANTS[asked.variant]
    groups = [ModelGroup(own, variant.built(one)) for own, one in zip(rows, inputs, strict=True)]
    return draw_columns(fly_groups(scenario, variant, groups, asked), each)


def fly_groups(
    scenario: Scenario, variant: Variant, groups: Sequence[ModelGroup], asked: VariantFlight
) -> Trace:
    """Return a flight of groups of vehicles in one room."""
    control = GroupedController(scenario.names, groups)
    shared = replace(
        blocks_of(scenario, BlockChoices(), NoInteraction()), controller=control, sense=control.sense
    )
    mode: Mode = "aware" if variant.aware else "ignoring"
    flight = fly_blocks(scenario, shared, LoopSettings(mode, SEED, asked.air))
    return Trace(flight.true_pos, flight.true_pos[..., 2] - flight.ref_pos[..., 2])


def draw_columns(trace: Trace, each: int) -> Array:
    """Return COLUMNS of every draw of `each` vehicles, (draws, 3); NaN if none was under another."""
    rows, t = [], np.asarray(TICK_S * np.arange(len(trace.pos)), dtype=np.float64)
    for start in range(0, trace.error.shape[1], each):
        own = slice(start, start + each)
        error, (under, clear) = trace.error[:, own], exposure(trace.pos[:, own], t)
        rows.append([rms(error[under]), rms(error[clear]), largest(error[under])])
    return np.array(rows)
