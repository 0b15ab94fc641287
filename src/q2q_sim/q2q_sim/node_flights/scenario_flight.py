"""Flight of a scenario through the real nodes: start, fly, end, measure from the bag.

Every node is a process of its own and communicates over DDS on this machine only. Parameters, plan, logs and
bag stay in the flight's folder, so that any node can be started again by hand.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

from q2q_model.bag import FlightFacts, facts_as_text
from q2q_model.flights.flight import Flight
from q2q_model.model_files.find_model import find_model
from q2q_model.signals.stamps import TICK_S
from q2q_model.signals.topic_names import PREDICTIONS
from q2q_model.trajectory import plan_file
from q2q_model.tunable import ParameterValue
from q2q_sim.bag_topics.scenario_facts import scenario_facts
from q2q_sim.bag_topics.topics import PREDICTION_TYPE
from q2q_sim.loop import flight_blocks
from q2q_sim.loop.flight_clock import FlightTiming
from q2q_sim.loop.scenario_air import air_of
from q2q_sim.loop.scenario_node_parameters import (
    controller_node_parameters,
    filter_node_parameters,
    replanner_node_parameters,
)
from q2q_sim.monitors.flight_judgement import verdict_of
from q2q_sim.monitors.flight_verdict import FlightVerdict, with_finding
from q2q_sim.monitors.metrics import FlightMetrics, measure
from q2q_sim.monitors.policies import Circumstances
from q2q_sim.monitors.recording_end import with_lost_ticks
from q2q_sim.node_flights.running_nodes import RECORDER, running_nodes
from q2q_sim.node_flights.unfinished_bag import end_of_bag, read_flown, why_unfinished
from q2q_sim.processes.cores import allowed_cores
from q2q_sim.processes.processes import NodeSpec
from q2q_sim.scenarios import library
from q2q_sim.scenarios.scenario import Scenario
from q2q_sim.scenarios.scenario_variants import with_air, with_choices

MEASURED = ("mocap", "truth", "truth_interference", "reference", "reference_safe", "command")
"""Topics that metrics and verdict need; a temporary bag has no others."""


@dataclass(frozen=True, slots=True)
class FlightRequest:
    """Request for a flight: scenario, controller and options."""

    scenario: str
    mode: str = "aware"
    """ignoring, aware (with the thrust limit) or aware_unlimited."""
    controller: str = "pid"
    replan: str = "none"
    """none, paper or safe."""
    plan: str = "none"
    """none, or avoid: plan around the downwash of the interaction model."""
    live: bool = False
    seed: int = 0
    model: str = ""
    """Interaction model in place of the scenario's; empty keeps that."""
    stack: bool = False
    """Run the nodes in one process; live, and if distributed, those from mocap_filter to controller."""
    distributed: bool = False
    """Fly one MPC node for each vehicle, which exchange predictions."""
    record: tuple[str, ...] = ()
    """Recorded topics; empty is all."""
    temporary: bool = False
    """Do not compress the bag: it is read once and deleted."""
    vehicle: str = ""
    """Vehicle in place of the scenario's; empty keeps that."""
    wake: str = ""
    """Wake in place of the scenario's; empty keeps that."""
    air: str = ""
    """Air in place of the scenario's wake and disturbance; empty keeps its own."""
    air_without: tuple[str, ...] = ()
    """Terms of the air that are switched off."""
    correct: bool = False
    """Correct the predicted downwash by positions and accelerometers."""

    @property
    def options(self) -> flight_blocks.BlockChoices:
        """Return the choices between blocks; raise ValueError for an unknown one."""
        return flight_blocks.BlockChoices(self.mode, self.controller, self.replan, self.correct)


@dataclass(frozen=True, slots=True)
class FlightRun:
    """Finished flight with its metrics."""

    request: FlightRequest
    flight: Flight
    metrics: FlightMetrics
    timing: FlightTiming
    bag: Path
    verdict: FlightVerdict


def load_scenario(request: FlightRequest) -> Scenario:
    """Return the scenario with the requested vehicle, wake, air and model; refuse what cannot be flown."""
    scenario = with_choices(library.load(request.scenario), request.vehicle, request.wake)
    scenario = with_air(scenario, request.air, request.air_without)
    if request.distributed and request.controller != "mpc":
        raise ValueError(f"--distributed with --controller {request.controller}: give --controller mpc")
    if request.plan == "avoid" and scenario.plan is not None:
        raise ValueError(f"{request.scenario} is flown by its own plan: leave out --plan avoid")
    flown = replace(scenario, model=request.model) if request.model else scenario
    find_model(flown.model)
    air_of(flown)
    return flown


def fly(request: FlightRequest, folder: Path, bag: Path, progress: Callable[[float], None]) -> FlightRun:
    """Fly a scenario and return its metrics and verdict.

    Args:
        request: scenario and options.
        folder: output folder for parameters, plan and logs.
        bag: output folder of the bag; must not exist.
        progress: called with the flown fraction, 0 to 1.

    Raises:
        ValueError: an unknown scenario, vehicle or parameter.
        BagError: nothing can be read from the bag.
        NodeDiedError, TimeoutError: a node did not start or ended early.
    """
    scenario = load_scenario(request)
    if bag.exists():
        raise ValueError(f"bag {bag} exists: choose another folder or delete it")
    folder.mkdir(parents=True, exist_ok=True)
    specs = node_specs(scenario, request, folder, bag)
    total = scenario.duration / TICK_S
    with running_nodes(specs, folder, lambda: progress(0.0)) as running:
        running.director.start()
        timing = running.director.wait_summary(lambda ticks: progress(ticks / total))
    return recorded_run(request, timing, folder, bag)


def recorded_run(request: FlightRequest, timing: FlightTiming, folder: Path, bag: Path) -> FlightRun:
    """Return metrics and verdict of a flight from its bag; one that is not finished is not ok.

    Raises:
        BagError: nothing can be read from the bag.
    """
    scenario, unfinished = load_scenario(request), why_unfinished(bag, folder)
    flight = read_flown(bag, unfinished)
    around = Circumstances(vehicle=scenario.vehicle, faults=scenario.faults)
    verdict = with_lost_ticks(verdict_of(flight, around, timing.missed_ticks), flight, timing.ticks)
    if unfinished:
        flown = timing.ticks * TICK_S
        verdict = with_finding(verdict, end_of_bag(bag, flight, flown, unfinished))
    return FlightRun(request, flight, measure(flight, scenario.vehicle), timing, bag, verdict)


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
        NodeSpec("q2q_control", request.controller, controller),
    )


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


def facts_of(scenario: Scenario, request: FlightRequest) -> FlightFacts:
    """Return the metadata for the bag of a flight."""
    return scenario_facts(scenario, request.options, request.seed, request.scenario)


def one_process(chain: tuple[NodeSpec, ...]) -> list[NodeSpec]:
    """Return the process that runs these nodes together."""
    names = tuple(spec.executable for spec in chain)
    return [NodeSpec("q2q_sim", "stack", {"nodes": names}, inside=chain)]
