"""Table 5 and Figs 10 to 13: the climbs of section 4.1, planned with and without the zone, and replanned."""

from pathlib import Path

import numpy as np

from q2q_model.flights.flight import Flight
from q2q_model.geometry.zone import Cylinder
from q2q_model.signals.values import Array
from q2q_planner.offline.avoidance.joint_plan import avoid_zones
from q2q_planner.offline.certificate.certificate import certify
from q2q_sim.experiments.paper.experiment_outcome import ExperimentOutcome, FigurePicture, Line, plot_panel
from q2q_sim.loop.closed_loop import FlightOptions, fly
from q2q_sim.loop.flight_blocks import plan_of
from q2q_sim.monitors.metrics.flight_metrics import best_position, tick_period
from q2q_sim.scenarios import library

SCENARIO = "section4_1"
ZONE = Cylinder()
"""The paper's I(0.1, 1.1)."""


def planning(folder: Path) -> ExperimentOutcome:
    """Plan with and without the zone, and fly both with the learned loop, the downwash not compensated."""
    scenario = library.load(SCENARIO)
    safe = avoid_zones(scenario.waypoints, ZONE, scenario.reading)
    again = avoid_zones(scenario.waypoints, ZONE, scenario.reading, warm=safe.plan)
    without = fly(scenario, FlightOptions(mode="ignoring"))
    around = fly(scenario, FlightOptions(mode="ignoring", plan=safe.plan))
    before, after = rms_error(without, without.ref_pos), rms_error(around, around.ref_pos)
    less = 100.0 * (1.0 - after / before)
    found = {
        "table5.ftol": abs(again.cost / safe.cost - 1.0),
        "fig10.clearance_without": certify(plan_of(scenario), ZONE).clearance,
        "fig10.clearance_with": safe.certificate.clearance,
        "fig11.rms_1_without": float(before[0]),
        "fig11.rms_2_without": float(before[1]),
        "fig11.rms_1_with": float(after[0]),
        "fig11.rms_2_with": float(after[1]),
        "fig11.reduction_1": float(less[0]),
        "fig11.reduction_2": float(less[1]),
    }
    both = {"without avoidance": without, "with avoidance": around}
    paths = (_gaps(folder, "fig10", {label: (one.t, one.ref_pos) for label, one in both.items()}),)
    return ExperimentOutcome(found, paths + _altitudes(folder, "fig11", both))


def replanning(folder: Path) -> ExperimentOutcome:
    """Fly the online replanner with the paper's parameters."""
    flight = fly(library.load(SCENARIO), FlightOptions(mode="ignoring", replan="paper"))
    inside = ZONE.signed_distance(flight.safe_pos[:, 1] - flight.safe_pos[:, 0]) < 0.0
    left = rms_error(flight, flight.safe_pos)
    found = {
        "fig12.zone_time": float(inside.sum()) * tick_period(flight),
        "fig13.rms_1": float(left[0]),
        "fig13.rms_2": float(left[1]),
    }
    gaps = {"planned": (flight.t, flight.ref_pos), "replanned": (flight.t, flight.safe_pos)}
    pictures = (_gaps(folder, "fig12", gaps), *_altitudes(folder, "fig13", {"replanned": flight}))
    return ExperimentOutcome(found, pictures)


def rms_error(flight: Flight, reference: Array) -> Array:
    """Return sqrt(mean (z - z_ref)^2) of every vehicle [m], (n,), against positions (T, n, 3)."""
    error = best_position(flight)[..., 2] - reference[..., 2]
    return np.asarray(np.sqrt(np.nanmean(error**2, axis=0)))


def _gaps(folder: Path, group: str, paths: dict[str, tuple[Array, Array]]) -> FigurePicture:
    """Draw the distances of pairs from the zone."""
    lines = [Line(label, t, ZONE.signed_distance(pos[:, 1] - pos[:, 0])) for label, (t, pos) in paths.items()]
    title = f"{group}: distance from the zone, negative inside"
    file = plot_panel(folder / f"{group}_distance.png", title, ("t [s]", "distance [m]"), lines)
    return FigurePicture(group, file, title)


def _altitudes(folder: Path, group: str, flights: dict[str, Flight]) -> tuple[FigurePicture, ...]:
    made = []
    for row in range(2):
        lines = [Line(label, one.t, best_position(one)[:, row, 2]) for label, one in flights.items()]
        first = next(iter(flights.values()))
        lines.append(Line("plan without avoidance", first.t, first.ref_pos[:, row, 2], "--"))
        title = f"{group}: altitude of Q{row + 1}"
        file = plot_panel(folder / f"{group}_q{row + 1}.png", title, ("t [s]", "z [m]"), lines)
        made.append(FigurePicture(group, file, title))
    return tuple(made)
