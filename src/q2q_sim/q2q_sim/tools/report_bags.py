"""Report on recorded flights: metrics and figures of all on one HTML page."""

import json
import sys
from argparse import Namespace
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from q2q_model.bag import TopicMap, read_flight, read_mapped_flight
from q2q_model.flights.flight import Flight
from q2q_model.signals.values import CommandStatus
from q2q_model.tools.bag_vehicle import FlownVehicle, flown_vehicle
from q2q_model.tools.recordings import topic_map
from q2q_sim.flight.run_json import Json, finite
from q2q_sim.monitors.flight_verdict import FlightVerdict, verdict_line, verdict_of
from q2q_sim.monitors.metrics import FlightMetrics, measure
from q2q_sim.monitors.mocap_quality import MocapQuality, mocap_quality
from q2q_sim.monitors.policies import Circumstances
from q2q_sim.report import figures
from q2q_sim.report.figures import PlotCurve
from q2q_sim.report.html_page import Grid, Picture, page
from q2q_sim.ros.recorded_diagnostics import NodeLife, recorded_lives

TRACKING = {
    "z_rmse_m": "z RMSE [m]",
    "xy_rmse_m": "xy RMSE [m]",
    "u1_energy": "U1 energy [N²s]",
    "u1_energy_above_hover": "above hover",
    "u1_max": "max U1 [N]",
    "under_rms_m": "z RMSE under another [m]",
    "clear_rms_m": "in clear air [m]",
    "worst_m": "worst under another [m]",
}
"""Columns of the first table by their field of VehicleMetrics."""
HEAD = ("flight", "vehicle", *TRACKING.values())
HEAD_LIMITS = ("flight", "vehicle", "saturated [%]", "fallback [%]", "separation [m]", "in zone [s]")
HEAD_NODES = ("flight", "node", "seconds", "in trouble", "worst", "last values")
HEAD_MOCAP = ("flight", "vehicle", "rate [Hz]", "seen [%]", "longest gap [s]", "not believed")


@dataclass(frozen=True, slots=True)
class Reported:
    """Flight with its metrics."""

    flight: Flight
    metrics: FlightMetrics
    quality: dict[str, MocapQuality]
    lives: tuple[NodeLife, ...]
    """Health of its nodes, if `/diagnostics` was recorded."""
    verdict: FlightVerdict
    note: str = ""
    """Assumed vehicle, if the bag does not name it."""


def run(args: Namespace) -> int:
    """Write the requested report; return the exit status."""
    topics, bags = topic_map(args.topics), [args.bag, *args.compare]
    flights = [reported(bag, flown_vehicle(bag, args.vehicle), topics) for bag in bags]
    write(flights, args.out)
    if args.json:
        args.json.write_text(json.dumps(as_json(flights), indent=1) + "\n")
    for note in notes(flights):
        print(f"report: {note}", file=sys.stderr)
    print(f"page: {args.out / 'index.html'}")
    print(verdicts(flights))
    return 0


def reported(bag: Path, flown: FlownVehicle, topics: TopicMap | None = None) -> Reported:
    """Return a bag's flight with its metrics; `topics` maps the topics of a foreign bag."""
    flight = read_flight(bag) if topics is None else read_mapped_flight(bag, topics)
    verdict = verdict_of(flight, Circumstances(vehicle=flown.vehicle))
    metrics, quality = measure(flight, flown.vehicle), mocap_quality(flight)
    return Reported(flight, metrics, quality, recorded_lives(bag), verdict, flown.note)


def verdicts(flights: Sequence[Reported]) -> str:
    """Return the verdicts on the flights in one line."""
    return verdict_line([(one.flight.name, one.verdict) for one in flights])


def notes(flights: Sequence[Reported]) -> list[str]:
    """Return the assumptions about the flights."""
    return [one.note for one in flights if one.note]


def write(flights: Sequence[Reported], out: Path) -> None:
    """Draw the pictures and write the page into a folder."""
    out.mkdir(parents=True, exist_ok=True)
    curves = [PlotCurve(one.flight, one.flight.name) for one in flights]
    pictures = [
        Picture(figures.save(draw(curves, name), out / f"{name}_{what}.png"), f"{name}: {what}")
        for what, draw in figures.KINDS.items()
        for name in flights[0].flight.names
    ]
    grids = [
        Grid(HEAD, [row for one in flights for row in _tracking(one)]),
        Grid(HEAD_LIMITS, [row for one in flights for row in _limits(one)]),
        Grid(HEAD_MOCAP, [row for one in flights for row in _mocap(one)]),
        *_nodes(flights),
    ]
    title = f"Flight {flights[0].flight.name}"
    lead = "Tracking against the plan, on the true positions where the bag has them."
    (out / "index.html").write_text(page(title, lead, [*grids, *notes(flights), verdicts(flights), pictures]))


def as_json(flights: Sequence[Reported]) -> Json:
    """Return the numbers of the tables."""
    return {
        one.flight.name: {
            name: {
                **{key: finite(value) for key, value in asdict(vehicle).items()},
                "mocap": {key: finite(value) for key, value in asdict(one.quality[name]).items()},
            }
            for name, vehicle in one.metrics.vehicles.items()
        }
        for one in flights
    }


def _tracking(one: Reported) -> list[tuple[str, ...]]:
    return [
        (one.flight.name, name, *(_text(numbers[field]) for field in TRACKING))
        for name, numbers in ((name, asdict(vehicle)) for name, vehicle in one.metrics.vehicles.items())
    ]


def _limits(one: Reported) -> list[tuple[str, ...]]:
    status = one.flight.command_status
    separation, zone_time = one.metrics.min_separation_m, one.metrics.zone_time_s
    return [
        (
            one.flight.name,
            name,
            _percent(status[:, row] == CommandStatus.SATURATED),
            _percent(status[:, row] >= CommandStatus.HOLD),
            _text(separation),
            _text(zone_time),
        )
        for row, name in enumerate(one.flight.names)
    ]


def _mocap(one: Reported) -> list[tuple[str, ...]]:
    return [
        (
            one.flight.name,
            name,
            f"{quality.rate_hz:.1f}",
            f"{100.0 * quality.seen_share:.2f}",
            _text(quality.longest_gap_s),
            str(quality.rejected),
        )
        for name, quality in one.quality.items()
    ]


def _nodes(flights: Sequence[Reported]) -> list[Grid]:
    """Return the table of the nodes; none if no bag has `/diagnostics`."""
    rows = [
        (one.flight.name, life.node, str(life.seconds), str(life.warned), life.worst.name, life.values)
        for one in flights
        for life in one.lives
    ]
    return [Grid(HEAD_NODES, rows)] if rows else []


def _percent(condition: NDArray[np.bool_]) -> str:
    return f"{100.0 * float(np.mean(condition)):.2f}" if len(condition) else "-"


def _text(value: float) -> str:
    return "-" if finite(value) is None else f"{value:.5g}"
