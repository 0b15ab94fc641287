"""Nodes of a flight with their parameters, and the processes they run in.

Every node is a process of its own and communicates over DDS on this machine only; those of a `stack` share
one. Parameters, plan, logs and bag stay in the flight's folder, so that any node can be started again by
hand.
"""

from dataclasses import replace
from pathlib import Path

from q2q_model.bag import facts_as_text
from q2q_model.model_files.find_model import find_model
from q2q_model.signals.topic_names import PREDICTIONS
from q2q_model.trajectory import plan_file
from q2q_model.tunable import ParameterValue
from q2q_sim.flight_bag.topics import PREDICTION_TYPE
from q2q_sim.loop import flight_blocks
from q2q_sim.node_flights.flight_request import FlightRequest, facts_of
from q2q_sim.node_flights.running_nodes import RECORDER
from q2q_sim.node_flights.scenario_node_parameters import (
    controller_node_parameters,
    filter_node_parameters,
    replanner_node_parameters,
)
from q2q_sim.processes.cores import allowed_cores
from q2q_sim.processes.processes import NodeSpec
from q2q_sim.scenarios.choices import CONTROLLERS, OWN_CONTROLLER
from q2q_sim.scenarios.scenario import Scenario


def node_specs(scenario: Scenario, request: FlightRequest, folder: Path, bag: Path) -> list[NodeSpec]:
    """Return the nodes of a flight with their parameters, and write their plan."""
    plan = folder / "plan.json"
    if request.plan == "avoid":
        plan_file.save(plan, flight_blocks.plan_around(scenario, find_model(scenario.model)))
    else:
        plan_file.save(plan, flight_blocks.plan_of(scenario))
    chain = _chain(scenario, request, plan)
    apart: tuple[NodeSpec, ...] = ()
    if request.distributed:
        chain, apart = chain[:-1], one_for_each(chain[-1], scenario.names)
    recorder, simulator = _recorder(scenario, request, bag), _simulator(request)
    if request.stack and not request.live and not apart:
        return one_process((*chain, simulator, recorder))  # the recorder last: it makes the bag
    return [recorder, *(one_process(chain) if request.stack else chain), *apart, simulator]


def one_for_each(mpc: NodeSpec, vehicles: tuple[str, ...]) -> tuple[NodeSpec, ...]:
    """Return a distributed node `mpc_<name>` for each vehicle, on any core: they compute at the same time."""
    cores = allowed_cores()
    return tuple(
        replace(
            mpc,
            name=f"mpc_{name}",
            parameters={**mpc.parameters, "vehicles": (name,), "distributed": True},
            cores=cores,
        )
        for name in vehicles
    )


def one_process(chain: tuple[NodeSpec, ...]) -> list[NodeSpec]:
    """Return the process that runs these nodes together."""
    names = tuple(spec.executable for spec in chain)
    return [NodeSpec("q2q_sim", "stack", {"nodes": names}, inside=chain)]


def _recorder(scenario: Scenario, request: FlightRequest, bag: Path) -> NodeSpec:
    predictions = request.distributed and (not request.record or PREDICTIONS in request.record)
    parameters: dict[str, ParameterValue] = {
        "bag": str(bag),
        "stamps": "receive" if request.live else "header",
        "compression": "none" if request.temporary else "zstd",
        "topics": tuple(topic for topic in request.record if not (predictions and topic == PREDICTIONS)),
        "extra": (f"{PREDICTIONS}:{PREDICTION_TYPE}",) if predictions else (),
        "facts": facts_as_text(facts_of(scenario, request)),
    }
    return NodeSpec("q2q_sim", RECORDER, parameters)


def _chain(scenario: Scenario, request: FlightRequest, plan: Path) -> tuple[NodeSpec, ...]:
    """Return the nodes from mocap_filter to controller."""
    replanner = replanner_node_parameters(scenario, request.options)
    controller = controller_node_parameters(scenario, request.options) | {"live": request.live}
    return (
        NodeSpec("q2q_model", "mocap_filter", filter_node_parameters(scenario)),
        NodeSpec("q2q_model", "interference", {"model": scenario.model}),
        NodeSpec("q2q_planner", "trajectory", {"plan": str(plan), "start": 0.0}),
        NodeSpec("q2q_planner", "replanner", replanner),
        NodeSpec("q2q_control", controller_node(request.controller), controller),
    )


def controller_node(controller: str) -> str:
    """Return the executable that runs a controller."""
    return controller if controller in CONTROLLERS else OWN_CONTROLLER


def _simulator(request: FlightRequest) -> NodeSpec:
    parameters: dict[str, ParameterValue] = {
        "scenario": request.scenario,
        "vehicle": request.vehicle,
        "wake": request.wake,
        "air": request.air,
        "air_without": request.air_without,
        "seed": request.seed,
        "pace": "live" if request.live else "lockstep",
        "autostart": False,
    }
    return NodeSpec("q2q_sim", "simulator", parameters)
