"""Parameters of the nodes of a flight, from its scenario: those of the blocks that they run."""

from dataclasses import asdict

from q2q_model.tunable import ParameterValue
from q2q_model.vehicle.constants import firmware_of
from q2q_model.vehicle.thrust_map import STOCK
from q2q_sim.loop.flight_blocks import (
    BlockChoices,
    filter_params,
    mpc_params,
    pid_params,
    replanner_params,
    safe_replanner_params,
    tracker_params,
)
from q2q_sim.scenarios.choices import CONTROLLERS
from q2q_sim.scenarios.scenario import Scenario

NodeParameters = dict[str, ParameterValue]
"""Values by name."""


def filter_node_parameters(scenario: Scenario) -> NodeParameters:
    """Return the parameters of the node mocap_filter."""
    return {"vehicles": scenario.names} | asdict(filter_params(scenario))


def replanner_node_parameters(scenario: Scenario, options: BlockChoices) -> NodeParameters:
    """Return the parameters of the node replanner."""
    if options.replan == "safe":
        safe = asdict(safe_replanner_params(scenario))
        return {"law": "safe"} | {f"safe.{key}": value for key, value in safe.items()}
    return {"law": "paper"} | asdict(replanner_params(scenario, enabled=options.replan == "paper"))


def controller_node_parameters(scenario: Scenario, options: BlockChoices) -> NodeParameters:
    """Return the parameters of the controller's node."""
    own: NodeParameters = {"vehicle": scenario.vehicle.name, "aware": options.aware}
    own |= {"firmware": firmware_of(scenario.vehicle) or STOCK, "vehicles": scenario.names}
    own |= {"correct": True} if options.correct else {}
    if options.controller not in CONTROLLERS:
        return own | {"controller": options.controller}
    if options.controller == "pid":
        known = {"model": scenario.model} | asdict(tracker_params(scenario)) if options.correct else {}
        return own | known | asdict(pid_params(scenario, limited=options.limited))
    return own | {"model": scenario.model} | asdict(mpc_params(scenario, limited=options.limited))
