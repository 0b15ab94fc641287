"""The demonstration's three flights, with bags, pictures and a page."""

import json
import shutil
from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path

from q2q_sim.flight.run_json import runs_json
from q2q_sim.flight.scenario_flight import FlightRequest, FlightRun
from q2q_sim.processes.interruption import Interruption
from q2q_sim.report.figures import PlotCurve, altitude_figure, save, thrust_figure
from q2q_sim.report.html_page import Picture, page
from q2q_sim.report.run_table import MODE_WORDS, run_grid, run_notes, run_verdicts
from q2q_sim.tools.fly_scenario import conclude, fly_with_progress
from q2q_sim.tools.fly_scenario import show as print_runs

SCENARIO = "table6"
LEAD = (
    "Q2 (cf2) passes 0.5 m above Q1 (cf1), which hovers at 1.5 m. Ignoring the downwash, Q1 is pushed down; "
    "aware of it, the PID adds the thrust that the downwash takes. The paper's Table 6 has 0.1315 m "
    "(ignoring) and 0.0280 m (aware, U1 at most 6.6 N). In this scenario alone the controller is given the "
    "wake's own law, as in the paper."
)


def run(args: Namespace) -> int:
    """Fly the demonstration; return the exit status."""
    return conclude(show(args.out, args.json))


def show(out: Path, json_file: Path | None) -> Sequence[FlightRun]:
    """Fly the three modes; print the table; write bags, pictures, page and JSON; return the flights."""
    shutil.rmtree(out / "bags", ignore_errors=True)
    interruption = Interruption()
    runs = [
        fly_with_progress(
            FlightRequest(SCENARIO, mode, stack=True), out / "nodes" / mode, out / "bags" / mode, interruption
        )
        for mode in MODE_WORDS
    ]
    print_runs(runs)
    pictures = draw(runs, out)
    (out / "index.html").write_text(
        page(
            "q2q: one Crazyflie over another",
            LEAD,
            [run_grid(runs), *run_notes(runs), run_verdicts(runs), pictures],
        )
    )
    print(f"page: {out / 'index.html'}")
    if json_file:
        json_file.parent.mkdir(parents=True, exist_ok=True)
        json_file.write_text(json.dumps(runs_json(runs), indent=1) + "\n")
    return runs


def draw(runs: Sequence[FlightRun], out: Path) -> list[Picture]:
    """Draw altitude and thrust of each vehicle, as Figs 14a-d; return the pictures."""
    curves = [PlotCurve(run.flight, MODE_WORDS[run.request.mode]) for run in runs]
    pictures = []
    for figure_of, what in ((altitude_figure, "altitude"), (thrust_figure, "thrust")):
        for name in runs[0].flight.names:
            path = save(figure_of(curves, name), out / f"{name}_{what}.png")
            pictures.append(Picture(path, f"{name}: {what}, as Fig. 14"))
    return pictures
