"""Request for a flight through nodes, and the scenario and metadata that it asks for."""

from dataclasses import dataclass, replace

from q2q_model.bag import FlightFacts
from q2q_model.model_files.find_model import find_model
from q2q_model.signals.topic_names import PREDICTIONS
from q2q_sim.flight_bag.scenario_facts import scenario_facts
from q2q_sim.loop import flight_blocks
from q2q_sim.loop.scenario_air import air_of
from q2q_sim.scenarios import library
from q2q_sim.scenarios.scenario import Scenario
from q2q_sim.scenarios.scenario_variants import check_wake_or_air, with_air, with_choices


@dataclass(frozen=True, slots=True)
class FlightRequest:
    """Request for a flight: scenario, controller and options."""

    scenario: str
    mode: str = "aware"
    """ignoring, aware (with the thrust limit) or aware_unlimited."""
    controller: str = "pid"
    """pid, mpc, or module:Class of the user's own."""
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

    def __post_init__(self) -> None:
        """Refuse choices of which one would be ignored."""
        if self.distributed and self.controller != "mpc":
            raise ValueError(f"distributed with controller = {self.controller!r}: give controller = 'mpc'")
        if PREDICTIONS in self.record and not self.distributed:
            raise ValueError(f"record {PREDICTIONS}: the flight is not distributed; record other topics")
        check_wake_or_air(self.wake, self.air)

    @property
    def options(self) -> flight_blocks.BlockChoices:
        """Return the choices between blocks; raise ValueError for an unknown one."""
        return flight_blocks.BlockChoices(self.mode, self.controller, self.replan, self.correct)


def load_scenario(request: FlightRequest) -> Scenario:
    """Return the scenario with the requested vehicle, wake, air and model; refuse what cannot be flown."""
    scenario = with_choices(library.load(request.scenario), request.vehicle, request.wake)
    scenario = with_air(scenario, request.air, request.air_without)
    if request.plan == "avoid" and scenario.plan is not None:
        raise ValueError(f"{request.scenario} is flown by its own plan: leave out --plan avoid")
    flown = replace(scenario, model=request.model) if request.model else scenario
    find_model(flown.model)
    air_of(flown)
    return flown


def facts_of(scenario: Scenario, request: FlightRequest) -> FlightFacts:
    """Return the metadata for the bag of a flight."""
    return scenario_facts(scenario, request.options, request.seed, request.scenario)
