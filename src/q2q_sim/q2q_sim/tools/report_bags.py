"""Report on recorded flights: metrics and figures of all on one HTML page."""

import sys
from argparse import Namespace
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np

from q2q_model.bag import TopicMap, read_facts
from q2q_model.documents.json_file import Json, write_json
from q2q_model.documents.written_file import write_text
from q2q_model.flights.flight import Flight
from q2q_model.identification.push.recorded_push import check_weight
from q2q_model.recordings.bag_vehicle import FlownVehicle, flown_vehicle
from q2q_model.recordings.filtered_states import with_filtered_states
from q2q_model.recordings.recording_reader import flight_of_bag
from q2q_model.recordings.recordings_of_bags import topic_map
from q2q_model.signals.values import Array, CommandStatus, Mask
from q2q_model.vehicle.constants import Vehicle
from q2q_sim.bag_topics.bag_verdict import bag_verdict
from q2q_sim.bag_topics.recorded_diagnostics import NodeLife, recorded_lives
from q2q_sim.monitors.flight_verdict import FlightVerdict, verdict_line
from q2q_sim.monitors.metrics.metrics import FlightMetrics, measure
from q2q_sim.monitors.mocap_quality import MocapQuality, mocap_quality
from q2q_sim.replay_page import MOST_RUNS, in_air, replay_element, replay_run
from q2q_sim.report import figures
from q2q_sim.report.figures import PlotCurve, plot_quantity
from q2q_sim.report.html_page import Grid, Heading, Markup, PageVerdict, Part, Picture, page
from q2q_sim.report.panels import picture_file, save
from q2q_sim.report.significant_digits import significant_digits
from q2q_sim.report.vehicle_rows import plotted_vehicles, vehicle_rows
from q2q_sim.tools.distinct_names import distinct_names

TRACKING = {
    "z_rmse_m": "z RMSE [m]",
    "xy_rmse_m": "xy RMSE [m]",
    "u1_energy": "control effort ∫ U1² dt [N²s]",
    "u1_energy_above_hover": "above hover [N²s]",
    "u1_max": "max U1 [N]",
    "under_rms_m": "z RMSE under another [m]",
    "clear_rms_m": "in clear air [m]",
    "worst_m": "worst under another [m]",
}
"""Columns of the first table by their field of VehicleMetrics."""
HEAD = ("flight", "vehicle", *TRACKING.values())
LIMITS = {
    "saturated_percent": "saturated [%]",
    "fallback_percent": "fallback [%]",
    "min_separation_m": "separation [m]",
    "zone_time_s": "in the zone [s]",
}
"""Columns of the second table by their key in the JSON."""
HEAD_LIMITS = ("flight", "vehicle", *LIMITS.values())
HEAD_NODES = ("flight", "node", "seconds", "in trouble", "worst", "last values")
HEAD_MOCAP = ("flight", "vehicle", "rate [Hz]", "seen [%]", "longest gap [s]", "rejected")


@dataclass(frozen=True, slots=True)
class Reported:
    """Flight with its metrics."""

    flight: Flight
    metrics: FlightMetrics
    quality: dict[str, MocapQuality]
    lives: tuple[NodeLife, ...]
    """Health of its nodes, if `/diagnostics` was recorded."""
    verdict: FlightVerdict
    vehicle: Vehicle
    note: str = ""
    """Assumed vehicle, if the bag does not name it."""
    air: str = ""
    """Air of the simulator, if known."""


def run(args: Namespace) -> int:
    """Write the requested report; return the exit status."""
    topics, bags = topic_map(args.topics), [args.bag, *args.compare]
    flights = [
        report_bag(bag, flown_vehicle(bag, args.vehicle), topics, name)
        for bag, name in zip(bags, distinct_names(bags), strict=True)
    ]
    write(flights, args.out)
    if args.json:
        write_json(as_json(flights), args.json)
    for note in notes(flights):
        print(f"report: {note}", file=sys.stderr)
    print(f"page: {args.out / 'index.html'}")
    print(verdicts(flights))
    return 0


def report_bag(bag: Path, flown: FlownVehicle, topics: TopicMap | None = None, name: str = "") -> Reported:
    """Return a bag's flight with its metrics, under a `name`; `topics` maps the topics of a foreign bag.

    Raises:
        ValueError: the commanded thrust does not carry the vehicle.
    """
    read = with_filtered_states(flight_of_bag(bag, topics))
    flight = replace(read, name=name or read.name)
    check_weight(flight, flown.vehicle)
    verdict = bag_verdict(bag, flight, flown.vehicle)
    metrics, quality = measure(flight, flown.vehicle), mocap_quality(flight)
    lives, air = recorded_lives(bag), read_facts(bag).flown_air
    return Reported(flight, metrics, quality, lives, verdict, flown.vehicle, flown.note, air)


def verdicts(flights: Sequence[Reported]) -> str:
    """Return the verdicts on the flights in one line."""
    return verdict_line([(one.flight.name, one.verdict) for one in flights])


def notes(flights: Sequence[Reported]) -> list[str]:
    """Return the assumptions about the flights."""
    return [one.note for one in flights if one.note]


def write(flights: Sequence[Reported], out: Path) -> None:
    """Draw the pictures and write the page into a folder: verdict, tables, pictures."""
    out.mkdir(parents=True, exist_ok=True)
    first = flights[0]
    pictures = _plot_quantities(flights, out)
    parts: list[Part] = [
        PageVerdict(verdicts(flights), all(one.verdict.ok for one in flights)),
        *notes(flights),
        _replay(flights),
        Heading("Tracking"),
        Grid(HEAD, [row for one in flights for row in _tracking(one)]),
        *([pictures] if pictures else []),
        Heading("Commands and separation"),
        Grid(HEAD_LIMITS, [row for one in flights for row in limit_rows(one)]),
        Heading("Motion capture"),
        Grid(HEAD_MOCAP, [row for one in flights for row in _mocap(one)]),
        *_nodes(flights),
    ]
    lead = "Tracking against the plan, on the true positions where the bag has them, else on filtered ones."
    html = page(f"Flight {first.flight.name}", lead, parts)
    write_text(html, out / "index.html")


def _replay(flights: Sequence[Reported]) -> Part:
    """Return the replay of the first flights side by side, or why there is none."""
    try:
        runs = [
            in_air(replay_run(one.flight, one.vehicle, verdict=one.verdict), one.air)
            for one in flights[:MOST_RUNS]
        ]
        return Markup(replay_element(runs))
    except ValueError as lacking:
        return f"No replay: {lacking}."


def _plot_quantities(flights: Sequence[Reported], out: Path) -> list[Picture]:
    """Plot what was recorded and can be seen, each vehicle apart; of many vehicles the worst."""
    curves = [PlotCurve(one.flight, one.flight.name, one.vehicle.thrust_max) for one in flights]
    shown = plotted_vehicles({name: one.z_rmse_m for name, one in flights[0].metrics.vehicles.items()})
    return [
        Picture(
            save(plot_quantity(kind, curves, name), picture_file(out, name, what)), f"{name}: {kind.title}"
        )
        for what, kind in figures.KINDS.items()
        for name in figures.recorded_vehicles(kind, curves)
        if name in shown
    ]


def as_json(flights: Sequence[Reported]) -> Json:
    """Return the numbers of the tables; NaN where unknown."""
    return {one.flight.name: _vehicles_json(one) for one in flights}


def _vehicles_json(one: Reported) -> Json:
    limits = _limits(one)
    return {
        name: {**asdict(vehicle), **limits[name], "mocap": asdict(one.quality[name])}
        for name, vehicle in one.metrics.vehicles.items()
    }


def _tracking(one: Reported) -> list[tuple[str, ...]]:
    numbers = {name: asdict(vehicle) for name, vehicle in one.metrics.vehicles.items()}
    return _lines(one, {name: [found[field] for field in TRACKING] for name, found in numbers.items()})


def limit_rows(one: Reported) -> list[tuple[str, ...]]:
    """Return the rows of the second table: shares of limited commands, and how close the vehicles came."""
    return _lines(one, {name: list(numbers.values()) for name, numbers in _limits(one).items()})


def _limits(one: Reported) -> dict[str, dict[str, float]]:
    """Return the numbers of the second table, by the keys of LIMITS, of each vehicle."""
    return {
        name: {
            "saturated_percent": _percent(status, status == CommandStatus.SATURATED),
            "fallback_percent": _percent(status, status >= CommandStatus.HOLD),
            "min_separation_m": one.metrics.min_separation_m,
            "zone_time_s": one.metrics.zone_time_s,
        }
        for name, status in zip(one.flight.names, one.flight.command_status.T, strict=True)
    }


def _mocap(one: Reported) -> list[tuple[str, ...]]:
    return _lines(
        one,
        {
            name: [found.rate_hz, 100.0 * found.seen_share, found.longest_gap_s, found.rejected]
            for name, found in one.quality.items()
        },
    )


def _lines(one: Reported, numbers: Mapping[str, Sequence[float]]) -> list[tuple[str, ...]]:
    """Return the rows of a table about one flight."""
    return [(one.flight.name, name, *map(significant_digits, row)) for name, row in vehicle_rows(numbers)]


def _nodes(flights: Sequence[Reported]) -> list[Part]:
    """Return heading and table of the nodes; none if no bag has `/diagnostics`."""
    rows = [
        (one.flight.name, life.node, str(life.seconds), str(life.warned), life.worst.name, life.values)
        for one in flights
        for life in one.lives
    ]
    return [Heading("Nodes"), Grid(HEAD_NODES, rows)] if rows else []


def _percent(status: Array, condition: Mask) -> float:
    """Return the share of ticks with a condition; NaN without any command."""
    return 100.0 * float(np.mean(condition)) if np.isfinite(status).any() else np.nan
