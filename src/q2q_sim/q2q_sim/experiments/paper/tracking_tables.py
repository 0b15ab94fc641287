"""Tables 6 and 7 and Figs 14 and 15: Q2 passes over Q1 under the PID and under the MPC.

The paper's numbers are reproduced in the paper's own air, whose law the controllers know. What compensation
is worth where they do not is measured in learned air: the same passage by Crazyflies (`table6_room` in the
air `room`, of the flights dc21), with a model learned from other flights (`measured_law`, of dc19).
"""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from q2q_model.downwash.jet import MEASURED_LAW
from q2q_model.flights.flight import Flight
from q2q_model.model_files.find_model import find_model
from q2q_sim.air.lookup.find_air import find_air
from q2q_sim.experiments.ablation.ablation_cases import PASSAGE, Case
from q2q_sim.experiments.ablation.learned_models import LearnedModel
from q2q_sim.experiments.ablation.variant_flight import COLUMNS, VariantFlight, fly_variant
from q2q_sim.experiments.paper.experiment_outcome import ExperimentOutcome, FigurePicture, Line, plot_panel
from q2q_sim.loop.closed_loop import FlightOptions, fly
from q2q_sim.loop.flight_blocks import Mode
from q2q_sim.monitors.metrics.flight_metrics import best_position, measure
from q2q_sim.report.figures import PlotCurve, thrust_limits
from q2q_sim.scenarios import library
from q2q_sim.scenarios.scenario import Scenario

SCENARIO = "table6"
VEHICLES = {"q1": "cf1", "q2": "cf2"}
"""The paper's names of the vehicles and ours."""
DRAWS = 8
"""Draws of the learned air."""


def pid(folder: Path) -> ExperimentOutcome:
    """Fly the PID ignoring the downwash, aware of it, and aware without the limit."""
    scenario = library.load(SCENARIO)
    modes: tuple[Mode, ...] = ("ignoring", "aware", "aware_unlimited")
    flights = {mode: _flown(scenario, mode, "pid") for mode in modes}
    found = {
        **_numbers(scenario, flights["ignoring"], "table6", "ignoring"),
        **_numbers(scenario, flights["aware"], "table6", "aware"),
        **_numbers(scenario, flights["aware"], "table7", "pd"),
    }
    unlimited = _numbers(scenario, flights["aware_unlimited"], "table6", "unlimited")
    found["table6.q1_z_rmse_unlimited"] = unlimited["table6.q1_z_rmse_unlimited"]
    found["fig14.q1_dip"] = _dip(flights["ignoring"])
    shown = {"ignoring": flights["ignoring"], "aware": flights["aware"]}
    found |= in_learned_air("table6", {"ignoring": "ignoring", "aware": "aware"})
    return ExperimentOutcome(found, _pictures(folder, "fig14", shown))


def mpc(folder: Path) -> ExperimentOutcome:
    """Fly the MPC, and for comparison the PD within its limit, both aware of the downwash."""
    scenario = library.load(SCENARIO)
    flight, beside = (_flown(scenario, "aware", controller) for controller in ("mpc", "pid"))
    dips = {"fig15.q1_dip": _dip(flight), "fig15.q1_dip_pd": _dip(beside)}
    found = _numbers(scenario, flight, "table7", "mpc") | dips
    found |= in_learned_air("table7", {"ignoring": "ignoring", "mpc": "MPC"})
    return ExperimentOutcome(found, _pictures(folder, "fig15", {"aware MPC": flight, "aware PD": beside}))


def in_learned_air(group: str, variants: Mapping[str, str]) -> dict[str, float]:
    """Return rms under another vehicle and in clear air, and worst error [m], medians over DRAWS.

    `variants` are the ablation's, by the suffix of their numbers.
    """
    found, case = {}, Case(PASSAGE)
    air, models = find_air(case.plant.air), (LearnedModel("measured_law", MEASURED_LAW),)
    for suffix, variant in variants.items():
        rows = fly_variant(VariantFlight(case, variant, models, air, DRAWS))
        for name in ("under", "clear", "worst"):
            middle = float(np.median(rows[:, COLUMNS.index(name)]))
            found[f"{group}.learned_air_{name}_{suffix}"] = middle
    return found


def _flown(scenario: Scenario, mode: Mode, controller: str) -> Flight:
    model = find_model(scenario.model).interaction
    return fly(scenario, FlightOptions(mode=mode, controller=controller, model=model))


def _numbers(scenario: Scenario, flight: Flight, group: str, suffix: str) -> dict[str, float]:
    vehicles = measure(flight, scenario.vehicle).vehicles
    found = {}
    for paper_name, name in VEHICLES.items():
        found[f"{group}.{paper_name}_z_rmse_{suffix}"] = vehicles[name].z_rmse_m
        found[f"{group}.{paper_name}_u1_energy_{suffix}"] = vehicles[name].u1_energy
    return found


def _dip(flight: Flight) -> float:
    """Return the largest height loss of Q1 below its reference [m]."""
    row = flight.names.index(VEHICLES["q1"])
    return float(np.nanmax(flight.ref_pos[:, row, 2] - best_position(flight)[:, row, 2]))


def _pictures(folder: Path, group: str, flights: dict[str, Flight]) -> tuple[FigurePicture, ...]:
    made = []
    for paper_name, name in VEHICLES.items():
        row = next(iter(flights.values())).names.index(name)
        z = [Line(label, one.t, best_position(one)[:, row, 2]) for label, one in flights.items()]
        first = next(iter(flights.values()))
        z.append(Line("reference", first.t, first.ref_pos[:, row, 2], "--"))
        thrust = [Line(label, one.t, one.thrust[:, row]) for label, one in flights.items()]
        limits = thrust_limits([PlotCurve(one, label) for label, one in flights.items()])
        thrust += [Line(words, first.t, np.full(len(first.t), value), ":") for value, words in limits.items()]
        for what, unit, lines in (("altitude", "z [m]", z), ("thrust", "U1 [N]", thrust)):
            title = f"{group}: {what} of {paper_name.upper()}"
            file = plot_panel(folder / f"{group}_{paper_name}_{what}.png", title, ("t [s]", unit), lines)
            made.append(FigurePicture(group, file, title))
    return tuple(made)
