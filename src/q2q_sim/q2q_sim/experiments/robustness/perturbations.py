"""Perturbations: what a controller believes wrongly of the downwash or its room, and what fails in flight."""

from dataclasses import dataclass, replace

from q2q_model.downwash.jet import Jet
from q2q_sim.faults.faults import Fault
from q2q_sim.scenarios.scenario import Scenario

PASSAGE = "table6_room"
GAP = 0.5
"""Height difference of the passage [m], at which delays are compared."""
SHORTEST = 1e-3
"""Minimum assumed delay [s]."""
HASTE = 0.5
"""Times of the waypoints over those of the scenario [-]."""


@dataclass(frozen=True, slots=True)
class Perturbation:
    """Difference between a flight and what its controller knows."""

    name: str
    scenario: str = PASSAGE
    strength: float = 1.0
    """Assumed strength of the jet over that of the model [-]."""
    delay: float = 0.0
    """Assumed delay less that of the model [s]."""
    latency: float = 0.0
    """Latency of the radio beyond the assumed one [s]."""
    silent: bool = False
    """No accelerometers arrive."""
    faults: tuple[Fault, ...] = ()


PERTURBATIONS = (
    Perturbation("none"),
    Perturbation("model 50 % too strong", strength=1.5),
    Perturbation("model 50 % too weak", strength=0.5),
    Perturbation("downwash assumed 50 ms late", delay=0.05),
    Perturbation("downwash assumed 50 ms early", delay=-0.05),
    Perturbation("15 ms more latency", latency=0.015),
    Perturbation("15 ms less latency", latency=-0.015),
    Perturbation("no accelerometers", silent=True),
    Perturbation("neighbour unseen for 0.5 s", faults=(Fault("dropout", 12.2, 0.5, ("cf2",)),)),
    Perturbation("a tenth of thrust lost", faults=(Fault("battery_sag", 7.0, 3.0, ("cf1",), 0.1),)),
    Perturbation("stack of three: saturated for seconds", scenario="stack3"),
    Perturbation("the same, model 50 % too strong", scenario="stack3", strength=1.5),
)


def with_faster_paths(scenario: Scenario) -> Scenario:
    """Return the scenario with its paths flown in HASTE of their time, to the same ends."""
    vehicles = tuple(
        replace(one, waypoints=tuple(replace(point, t=HASTE * point.t) for point in one.waypoints))
        for one in scenario.waypoints
    )
    return replace(scenario, waypoints=vehicles, duration=HASTE * scenario.duration)


def assumed_model(model: Jet, one: Perturbation) -> Jet:
    """Return the model that the controller is given."""
    changed = replace(model, strength=one.strength * model.strength)
    if one.delay == 0.0:
        return changed
    delay = (GAP / model.travel_speed if model.travel_speed > 0.0 else 0.0) + one.delay
    return replace(changed, travel_speed=GAP / max(delay, SHORTEST))


def flown_room(scenario: Scenario, one: Perturbation) -> Scenario:
    """Return the room that is flown in; names of vehicles begin with those of the faults."""
    radio = replace(scenario.radio, latency=scenario.radio.latency + one.latency)
    faults = tuple(
        replace(fault, vehicles=tuple(name for name in scenario.names if name.startswith(fault.vehicles)))
        for fault in one.faults
    )
    return replace(scenario, radio=radio, faults=faults)


def without_model_errors(one: Perturbation) -> Perturbation:
    """Return what is left of a perturbation for a controller that ignores the downwash."""
    return replace(one, name="", strength=1.0, delay=0.0, silent=False)
