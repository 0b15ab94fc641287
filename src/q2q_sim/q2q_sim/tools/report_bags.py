"""Report on recorded flights: metrics and figures of all on one HTML page."""

import sys
from argparse import Namespace
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from q2q_model.bag import TopicMap, read_facts
from q2q_model.documents.json_file import write_json
from q2q_model.documents.written_file import write_text
from q2q_model.flights.units_and_frames.frame_notes import frame_notes
from q2q_model.identification.push.recorded_push import check_weight
from q2q_model.recordings.bag_vehicle import FlownVehicle, flown_vehicle
from q2q_model.recordings.filtered_states import with_filtered_states
from q2q_model.recordings.recording_reader import flight_of_bag
from q2q_model.recordings.recordings_of_bags import topic_map
from q2q_sim.flight_bag.bag_verdict import bag_verdict
from q2q_sim.flight_bag.recorded_diagnostics import recorded_lives
from q2q_sim.monitors.flight_verdict import verdict_line
from q2q_sim.monitors.metrics.flight_metrics import measure
from q2q_sim.monitors.mocap_quality import mocap_quality
from q2q_sim.replay_page import MOST_RUNS, in_air, replay_element, replay_run
from q2q_sim.report import figures
from q2q_sim.report.bag_tables import (
    Reported,
    as_json,
    limits_table,
    mocap_table,
    nodes_table,
    tracking_table,
)
from q2q_sim.report.figures import PlotCurve, plot_quantity
from q2q_sim.report.html_page import Heading, Markup, PageVerdict, Part, Picture, page
from q2q_sim.report.panels import picture_file, save
from q2q_sim.report.vehicle_rows import drawn_vehicles_note, plotted_vehicles
from q2q_sim.tools.distinct_names import distinct_names


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
    """Return the assumptions about the flights, and doubts about their frames."""
    return [note for one in flights for note in (one.note, *frame_notes(one.flight)) if note]


def write(flights: Sequence[Reported], out: Path) -> None:
    """Draw the pictures and write the page into a folder: verdict, tables, pictures."""
    first = flights[0]
    pictures = _plot_quantities(flights, out)
    parts: list[Part] = [
        PageVerdict(verdicts(flights), all(one.verdict.ok for one in flights)),
        *notes(flights),
        _replay(flights),
        Heading("Tracking"),
        tracking_table(flights),
        *(_choice(first) if pictures else []),
        *([pictures] if pictures else []),
        Heading("Commands and separation"),
        limits_table(flights),
        Heading("Motion capture"),
        mocap_table(flights),
        *nodes_table(flights),
    ]
    lead = "Tracking against the plan, on the true positions where the bag has them, else on filtered ones."
    html = page(f"Flight {first.flight.name}", lead, parts)
    write_text(html, out / "index.html")


def _choice(one: Reported) -> list[str]:
    return drawn_vehicles_note(len(one.flight.names), one.flight.name)


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
