"""Build the blocks of a flight from its scenario, and say their parameters: for nodes and for `closed_loop`.

Both roads take plan and parameters from here, so that they fly the same.
"""

from dataclasses import asdict, dataclass, replace
from typing import Literal

from q2q_control.controller import Controller
from q2q_control.pid import Pid, PidParams
from q2q_model.interaction.model import InteractionModel
from q2q_model.interaction.predictor import InteractionPredictor
from q2q_model.mocap_filter import MocapFilter, MocapFilterParams
from q2q_model.parameters import ParameterValue
from q2q_planner.minsnap import minimum_snap_plan
from q2q_planner.potential_field import PotentialField, PotentialFieldParams
from q2q_planner.replanner import Replanner
from q2q_planner.trajectory import SwarmPlan
from q2q_sim.room import TICK_S
from q2q_sim.scenario import Scenario, block_params

__all__ = ["TICK_S", "Blocks", "Mode", "blocks_of", "plan_of"]

Mode = Literal["ignoring", "aware", "aware_unlimited"]
MODES: tuple[Mode, ...] = ("ignoring", "aware", "aware_unlimited")

NodeParameters = dict[str, ParameterValue]


@dataclass(frozen=True, slots=True)
class Blocks:
    """Hold the blocks of one flight, in the order of the road."""

    plan: SwarmPlan
    mocap_filter: MocapFilter
    predictor: InteractionPredictor
    replanner: Replanner
    controller: Controller


def plan_of(scenario: Scenario) -> SwarmPlan:
    """Return the scenario's minimum-snap plan."""
    return minimum_snap_plan(scenario.waypoints, scenario.reading)


def filter_params(scenario: Scenario) -> MocapFilterParams:
    """Return the mocap filter's parameters."""
    return block_params("mocap_filter", MocapFilterParams(), scenario.overrides)


def replanner_params(scenario: Scenario, *, enabled: bool) -> PotentialFieldParams:
    """Return the replanner's parameters; not enabled, it passes setpoints through."""
    return replace(block_params("replanner", PotentialFieldParams(), scenario.overrides), enabled=enabled)


def pid_params(scenario: Scenario, *, limited: bool) -> PidParams:
    """Return the PID's parameters, with or without the scenario's thrust limit."""
    return replace(block_params("pid", PidParams(), scenario.overrides), thrust_limited=limited)


def blocks_of(scenario: Scenario, mode: Mode, model: InteractionModel, *, replan: bool) -> Blocks:
    """Return fresh blocks for a flight with the PID.

    Raises:
        ValueError: unknown mode.
    """
    if mode not in MODES:
        raise ValueError(f"unknown mode {mode!r}: choose one of {', '.join(MODES)}")
    return Blocks(
        plan=plan_of(scenario),
        mocap_filter=MocapFilter(filter_params(scenario), scenario.names),
        predictor=InteractionPredictor(model),
        replanner=PotentialField(replanner_params(scenario, enabled=replan)),
        controller=Pid(pid_params(scenario, limited=mode != "aware_unlimited"), scenario.vehicle),
    )


def filter_parameters(scenario: Scenario) -> NodeParameters:
    """Return the parameters of the node mocap_filter."""
    own: NodeParameters = {"vehicles": scenario.names}
    return own | asdict(filter_params(scenario))


def replanner_parameters(scenario: Scenario, *, enabled: bool) -> NodeParameters:
    """Return the parameters of the node replanner."""
    return asdict(replanner_params(scenario, enabled=enabled))


def controller_parameters(scenario: Scenario, *, aware: bool, limited: bool) -> NodeParameters:
    """Return the parameters of the node pid."""
    own: NodeParameters = {"vehicle": scenario.vehicle.name, "aware": aware}
    return own | asdict(pid_params(scenario, limited=limited))
