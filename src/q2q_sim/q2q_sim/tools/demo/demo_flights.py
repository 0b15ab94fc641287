"""The demonstration's three flights, with bags, pictures and a page."""

import shutil
from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path

from q2q_model import palette
from q2q_model.documents.json_file import write_json
from q2q_model.documents.written_file import write_text
from q2q_model.flights.flight import Flight
from q2q_sim.monitors.metrics.exposure import exposed
from q2q_sim.monitors.metrics.flight_metrics import FlightMetrics, best_position
from q2q_sim.node_flights.flight_request import FlightRequest, load_scenario
from q2q_sim.node_flights.flight_run import FlightRun, runs_json
from q2q_sim.processes.interruption import Interruption
from q2q_sim.replay_page import in_air, replay_element, replay_run
from q2q_sim.report.figures import KINDS, PlotCurve, plot_quantity
from q2q_sim.report.html_page import (
    Heading,
    KeyNumber,
    Markup,
    PageVerdict,
    Part,
    Picture,
    TextWithCode,
    page,
)
from q2q_sim.report.panels import picture_file, save
from q2q_sim.report.run_table import MODE_WORDS, run_grid, run_notes, run_verdicts
from q2q_sim.report.significant_digits import centimetres
from q2q_sim.report.vehicle_rows import plotted_vehicles
from q2q_sim.tools.fly_scenario import fly_with_progress, print_verdict
from q2q_sim.tools.fly_scenario import print_flights as print_runs
from q2q_sim.tools.write_replay import part_of_flight

SCENARIO = "table6"
LEAD = "Q2 (cf2) passes 0.5 m above Q1 (cf1), which hovers in its downwash."
NOTE = (
    "The paper's Table 6 has 0.1315 m of z RMSE ignoring the downwash and 0.0280 m aware of it, with U1 at "
    "most 6.6 N. As in the paper, the vehicles weigh 0.65 kg and the controller is given the wake's own law: "
    "for Crazyflies in air learned from recorded flights, run `scripts/demo --real`."
)
AROUND = 3.0
"""Time before and after a passage that is replayed [s]: the fall and the return of the lower vehicle."""
DRAWN = ("altitude", "thrust")
"""As Figs 14a-d."""


def run(args: Namespace) -> int:
    """Fly the demonstration; return the exit status."""
    return print_verdict(fly_and_show(args.out, args.json))


def fly_and_show(out: Path, json_file: Path | None) -> Sequence[FlightRun]:
    """Fly the three modes; print the table; write bags, pictures, page and JSON; return the flights."""
    runs = fly_requests([FlightRequest(SCENARIO, mode, stack=True) for mode in MODE_WORDS], out)
    if json_file:
        write_json(runs_json(runs), json_file)
    print_runs(runs)
    print_numbers(runs)
    write_demo_page(runs, out)
    return runs


def fly_requests(requests: Sequence[FlightRequest], out: Path) -> list[FlightRun]:
    """Fly requests of different modes into `out`/bags, whose earlier bags are deleted."""
    shutil.rmtree(out / "bags", ignore_errors=True)
    interruption = Interruption()
    return [
        fly_with_progress(one, out / "nodes" / one.mode, out / "bags" / one.mode, interruption)
        for one in requests
    ]


def write_demo_page(runs: Sequence[FlightRun], out: Path) -> None:
    """Write the page: replay, the two numbers, table, pictures."""
    numbers = key_numbers(runs[0].metrics, runs[1].metrics)
    parts: list[Part] = [
        replay_of(*runs[:2]),
        *([numbers] if numbers else []),
        PageVerdict(run_verdicts(runs), all(run.verdict.ok for run in runs)),
        run_grid(runs),
        TextWithCode(NOTE),
        Heading("As Figs 14a-d of the paper"),
        plot_runs(runs, out),
        *run_notes(runs),
    ]
    html = page("q2q: one quadcopter over another", LEAD, parts)
    write_text(html, out / "index.html")
    print(f"page: {out / 'index.html'}")


def replay_of(ignoring: FlightRun, aware: FlightRun) -> Markup:
    """Return the replay of the passage in two flights side by side."""
    flown = load_scenario(ignoring.request)
    start, end = passage_times(ignoring.flight)
    runs = []
    for run in (ignoring, aware):
        part, name = part_of_flight(run.flight, start, end), MODE_WORDS[run.request.mode]
        runs.append(in_air(replay_run(part, flown.vehicle, name, whole=run.flight), flown.air or flown.wake))
    return Markup(replay_element(runs))


def passage_times(flight: Flight) -> tuple[float, float]:
    """Return when any vehicle is under another, with some time around it [s since the start]; else all."""
    since = flight.t - flight.t[0]
    under = exposed(best_position(flight), flight.t, after=0.0).any(axis=1)
    if not under.any():
        return 0.0, float(since[-1])
    first, last = float(since[under][0]), float(since[under][-1])
    return max(first - AROUND, 0.0), min(last + AROUND, float(since[-1]))


def key_numbers(ignoring: FlightMetrics, aware: FlightMetrics) -> list[KeyNumber]:
    """Return the largest height error under another vehicle and that of the same vehicle with q2q, if any."""
    worst = {name: one.worst_m for name, one in ignoring.vehicles.items() if one.worst_m > 0.0}
    if not worst:
        return []
    name = max(worst, key=lambda one: worst[one])
    without, left = worst[name], aware.vehicles[name].worst_m
    words = f"largest height error of {name} under another vehicle, ignoring the downwash"
    return [
        KeyNumber(centimetres(without), words, palette.FLIGHTS[0]),
        KeyNumber(centimetres(left), "with q2q", palette.FLIGHTS[1]),
    ]


def print_numbers(runs: Sequence[FlightRun]) -> None:
    """Print the key numbers in one line, if there are any."""
    numbers = key_numbers(runs[0].metrics, runs[1].metrics)
    if numbers:
        print("; ".join(f"{one.value}: {one.meaning}" for one in numbers))


def plot_runs(runs: Sequence[FlightRun], out: Path) -> list[Picture]:
    """Plot altitude and thrust of each vehicle; return the pictures."""
    curves = [PlotCurve(run.flight, MODE_WORDS[run.request.mode]) for run in runs]
    errors = {name: one.z_rmse_m for name, one in runs[0].metrics.vehicles.items()}
    return [
        Picture(
            save(plot_quantity(KINDS[what], curves, name), picture_file(out, name, what)), f"{name}: {what}"
        )
        for what in DRAWN
        for name in plotted_vehicles(errors)
    ]
