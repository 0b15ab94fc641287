"""Simulated accidents with a known first cause.

Three Crazyflies: cf1 hovers, cf2 and cf3 come and stay beside it, higher. A flight in an ordinary room, with
ordinary gains, stays on its path; the same flight with the same noise, into which one cause is injected, does
not. That cause is the first: without it there is no accident.

| cause | injected |
|---|---|
| downwash | cf2 and cf3 stay right above cf1, and the controller ignores the wake |
| battery and saturation | fault battery_sag or weak_rotor |
| motion capture | fault jump, swap, dropout or stale |
| latency | latency of the radio, or fault late |
| lost messages | fault radio_loss, or loss of the radio |
| control | gains far too low, or hardly any damping |
| wind | gusts |

Sizes are drawn at random, from what the stack withstands to what no vehicle does; what is not an accident is
drawn again.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from q2q_model.signals.values import Names
from q2q_sim.campaigns.random_runs.random_run import GAINS, ROOMS
from q2q_sim.experiments.explanation.flight_setup import FlightSetup, flight_setup, fly_setup
from q2q_sim.experiments.explanation.loss import ACCIDENT, ORDINARY, largest_loss
from q2q_sim.faults.faults import Fault
from q2q_sim.loop.flight_blocks import BlockChoices
from q2q_sim.random_streams import stream
from q2q_sim.scenarios.scenario_document import scenario_from_document

TRIES = 100
"""Flights that are drawn for an accident."""
GAIN_FACTORS = (0.7, 1.3)
"""Range of ordinary gains over GAINS [-]."""
GAPS, ASIDE = (0.3, 0.8), (0.15, 0.4)
"""Ordinary height differences of neighbours, and distances from the vertical through cf1 [m]."""
RIGHT_ABOVE = (0.0, 0.03)
"""Distances from the vertical through cf1 in its downwash [m]."""
COME, STAY = 2.0, 6.0
"""When cf2 and cf3 arrive, and the flight ends [s]."""
STRUCK = (2.0, 3.0)
"""When faults begin [s]."""

Injection = Callable[[FlightSetup, np.random.Generator], FlightSetup]


@dataclass(frozen=True, slots=True)
class Accident:
    """Accident and its first cause."""

    setup: FlightSetup
    first: str


def accident(seed: int) -> Accident:
    """Return the accident of a seed (0 or above).

    Raises:
        ValueError: none was found in TRIES flights.
    """
    rng = stream(seed, "accident")
    first = str(rng.choice(list(INJECTIONS)))
    for _ in range(TRIES):
        before = ordinary_flight(seed, rng)
        after = INJECTIONS[first](before, rng)
        if _distance(after) >= ACCIDENT and _distance(before) <= ORDINARY:
            return Accident(after, first)
    raise ValueError(f"seed {seed}: none of {TRIES} flights is an accident by {first}")


def ordinary_flight(seed: int, rng: np.random.Generator) -> FlightSetup:
    """Return a random flight in an ordinary room."""
    gains = {name: gain * float(rng.uniform(*GAIN_FACTORS)) for name, gain in GAINS.items()}
    document = {
        "vehicles": _paths(float(rng.uniform(*GAPS)), float(rng.uniform(*ASIDE))),
        "vehicle": "crazyflie_2_0",
        "wake": "measured",
        "model": "measured_law",
        "room": str(rng.choice(ROOMS)),
        "overrides": {"pid": gains},
    }
    mode = str(rng.choice(["ignoring", "aware_unlimited"]))
    return flight_setup(scenario_from_document("accident", document), BlockChoices(mode), seed)


def _paths(gap: float, aside: float) -> dict[str, object]:
    """Return the waypoints of cf1, and of cf2 and cf3 above and beside it."""
    return {
        "cf1": _way((0.0, -0.2, 1.0), (0.0, 0.0, 1.0)),
        "cf2": _way((-0.3, aside, 1.0 + gap), (0.0, aside, 1.0 + gap)),
        "cf3": _way((0.3, -aside, 1.0 + 2.0 * gap), (0.0, -aside, 1.0 + 2.0 * gap)),
    }


def _way(begin: tuple[float, float, float], end: tuple[float, float, float]) -> list[dict[str, object]]:
    return [{"t": t, "pos": list(pos)} for t, pos in ((0.0, begin), (COME, end), (STAY, end))]


def _distance(setup: FlightSetup) -> float:
    return largest_loss(fly_setup(setup)).size


def _stacked(setup: FlightSetup, rng: np.random.Generator) -> FlightSetup:
    above = _paths(float(rng.uniform(*GAPS)), float(rng.uniform(*RIGHT_ABOVE)))
    waypoints = scenario_from_document("stack", {"vehicles": above}).waypoints
    scenario = replace(setup.scenario, waypoints=waypoints)
    return flight_setup(scenario, replace(setup.options, mode="ignoring"), setup.seed)


def _weak(setup: FlightSetup, rng: np.random.Generator) -> FlightSetup:
    kind = str(rng.choice(["battery_sag", "weak_rotor"]))
    return _with_fault(setup, rng, kind, lasts=(1.0, 3.0), size=(0.1, 0.7))


def _misled(setup: FlightSetup, rng: np.random.Generator) -> FlightSetup:
    kind = str(rng.choice(["jump", "swap", "dropout", "stale"]))
    sizes = (0.3, 1.0) if kind == "jump" else (0.0, 0.0)
    return _with_fault(setup, rng, kind, lasts=(0.3, 3.0), size=sizes)


def _late(setup: FlightSetup, rng: np.random.Generator) -> FlightSetup:
    if rng.random() < 0.5:
        return _with_fault(setup, rng, "late", lasts=(0.5, 3.0), size=(0.05, 0.4))
    radio = replace(setup.scenario.radio, latency=float(rng.uniform(0.05, 0.4)))
    return replace(setup, scenario=replace(setup.scenario, radio=radio))


def _deaf(setup: FlightSetup, rng: np.random.Generator) -> FlightSetup:
    if rng.random() < 0.5:
        return _with_fault(setup, rng, "radio_loss", lasts=(0.3, 3.0), size=(0.7, 1.0))
    radio = replace(setup.scenario.radio, loss=float(rng.uniform(0.7, 0.99)))
    return replace(setup, scenario=replace(setup.scenario, radio=radio))


def _badly_tuned(setup: FlightSetup, rng: np.random.Generator) -> FlightSetup:
    changed = ["k_p_z", "k_p_xy", "k_i_z", "k_i_xy"] if rng.random() < 0.5 else ["k_d_z", "k_d_xy"]
    own = dict(setup.scenario.overrides["pid"])
    for name in changed:
        own[name] = GAINS[name] * float(rng.uniform(0.0, 0.3))
    return replace(
        setup, scenario=replace(setup.scenario, overrides={**setup.scenario.overrides, "pid": own})
    )


def _gusty(setup: FlightSetup, rng: np.random.Generator) -> FlightSetup:
    air = replace(setup.scenario.disturbance, air_std=float(rng.uniform(0.5, 4.0)))
    return replace(setup, scenario=replace(setup.scenario, disturbance=air))


def _with_fault(
    setup: FlightSetup,
    rng: np.random.Generator,
    kind: str,
    *,
    lasts: tuple[float, float],
    size: tuple[float, float],
) -> FlightSetup:
    fault = Fault(
        kind=kind,
        start=float(rng.uniform(*STRUCK)),
        duration=float(rng.uniform(*lasts)),
        vehicles=_named_vehicles(kind, setup.scenario.names),
        size=float(rng.uniform(*size)),
    )
    return replace(setup, scenario=replace(setup.scenario, faults=(fault,)))


def _named_vehicles(kind: str, names: Names) -> Names:
    """Return the vehicles that a fault names: cf1; both that are swapped; none for a whole frame."""
    return {"swap": names[:2], "late": (), "stale": ()}.get(kind, names[:1])


INJECTIONS: Mapping[str, Injection] = {
    "downwash": _stacked,
    "battery and saturation": _weak,
    "motion capture": _misled,
    "latency": _late,
    "lost messages": _deaf,
    "control": _badly_tuned,
    "wind": _gusty,
}
