"""Table of flights, one row for each vehicle and mode, as the paper's Table 6."""

from collections.abc import Sequence

from rich.box import SIMPLE_HEAD
from rich.markup import escape
from rich.table import Table

from q2q_sim.flight.run_json import finite
from q2q_sim.flight.scenario_flight import FlightRun
from q2q_sim.monitors.flight_verdict import verdict_line
from q2q_sim.report.html_page import Grid

MODE_WORDS = {
    "ignoring": "ignoring",
    "aware": "aware",
    "aware_unlimited": "no limit",
}
HEAD = (
    "mode",
    "vehicle",
    "z RMSE\n[m]",
    "xy RMSE\n[m]",
    "U1 energy\n[N²s]",
    "above\nhover",
    "max U1\n[N]",
    "separation\n[m]",
)


def run_grid(runs: Sequence[FlightRun]) -> Grid:
    """Return the cells of the table."""
    return Grid(HEAD, [row for run in runs for row in _rows(run)])


def run_table(runs: Sequence[FlightRun]) -> Table:
    """Return the table for a terminal of 80 columns."""
    title = f"{runs[0].request.scenario}, {runs[0].request.controller}"
    table = Table(title=title, title_justify="left", box=SIMPLE_HEAD, padding=(0, 1, 0, 0))
    for position, column in enumerate(HEAD):
        table.add_column(escape(column), justify="left" if position < 2 else "right")
    for run in runs:
        for row in _rows(run):
            table.add_row(*row)
    return table


def run_notes(runs: Sequence[FlightRun]) -> list[str]:
    """Print zone time and timing of each flight."""
    return [_note(run) for run in runs]


def run_verdicts(runs: Sequence[FlightRun]) -> str:
    """Return the verdicts on the flights in one line."""
    return verdict_line([(MODE_WORDS[run.request.mode], run.verdict) for run in runs])


def _note(run: FlightRun) -> str:
    timing = run.timing
    return (
        f"{MODE_WORDS[run.request.mode]}: {_number(run.metrics.zone_time_s, 2)} s in the zone, "
        f"{_number(timing.real_time_factor, 1)} x real time, {timing.missed_ticks} ticks missed, "
        f"mocap to command {_number(timing.latency_p50_ms, 2)} ms (p99 {_number(timing.latency_p99_ms, 2)})"
    )


def _rows(run: FlightRun) -> list[tuple[str, ...]]:
    return [
        (
            MODE_WORDS[run.request.mode],
            name,
            _number(one.z_rmse_m, 5),
            _number(one.xy_rmse_m, 5),
            _number(one.u1_energy, 2),
            _number(one.u1_energy_above_hover, 2),
            _number(one.u1_max, 3),
            _number(run.metrics.min_separation_m, 3),
        )
        for name, one in run.metrics.vehicles.items()
    ]


def _number(value: float | None, digits: int) -> str:
    known = finite(value)
    return "-" if known is None else f"{known:.{digits}f}"
