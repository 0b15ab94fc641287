"""First half seconds of flights, and an explanation of one."""

from dataclasses import replace

from q2q_sim.experiments.explanation.explanation import CauseShare, Explanation
from q2q_sim.experiments.explanation.flight_setup import FlightSetup, flight_setup
from q2q_sim.experiments.explanation.loss import Loss
from q2q_sim.loop.flight_blocks import BlockChoices
from q2q_sim.scenarios import library
from q2q_sim.scenarios.scenario_variants import with_air

FOUND = Explanation(
    loss=Loss("height", "cf1", 0, 3.25, 0.83),
    shares=(CauseShare("downwash", 0.61, 0.55, 0.67), CauseShare("latency", 0.1, 0.08, 0.12)),
    first="downwash",
    rest=0.12,
    without_first=0.2,
    all_orders=False,
    draws=3,
)


def short(name: str, air: str = "") -> FlightSetup:
    """Return the first half second of a scenario."""
    scenario = replace(with_air(library.load(name), air, ()), duration=0.5)
    return flight_setup(scenario, BlockChoices("ignoring"), 0)
