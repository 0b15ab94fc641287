"""Table of flights, one row for each vehicle and mode, as the paper's Table 6; a summary of many vehicles."""

import math
from collections.abc import Sequence

from rich.box import SIMPLE_HEAD
from rich.console import JustifyMethod
from rich.table import Table

from q2q_model.counted import counted
from q2q_model.plain_console import plain_console
from q2q_sim.monitors.flight_verdict import verdict_line
from q2q_sim.monitors.metrics.flight_metrics import FlightMetrics, VehicleMetrics
from q2q_sim.node_flights.flight_request import FlightRequest
from q2q_sim.node_flights.flight_run import FlightRun
from q2q_sim.report.html_page import Grid
from q2q_sim.report.significant_digits import significant_digits
from q2q_sim.report.vehicle_rows import vehicle_rows

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
    "control\neffort\n[N²s]",
    "above\nhover\n[N²s]",
    "max U1\n[N]",
    "separation\n[m]",
)

UNBOUNDED = 10_000
"""Width of a terminal that no table reaches."""
LEAST_NAME = 12
"""Letters of a vehicle's name in one line of a row, at least."""


def run_grid(runs: Sequence[FlightRun]) -> Grid:
    """Return the cells of the table."""
    return Grid(HEAD, [row for run in runs for row in _rows(run)])


def run_table(runs: Sequence[FlightRun], width: int) -> Table:
    """Return the table for a plain console of some width: a row for each vehicle, or one for each number.

    Long names of vehicles are broken; numbers never are.
    """
    grid, flown = run_grid(runs), runs[0].request
    named = [(mode, name[:LEAST_NAME], *numbers) for mode, name, *numbers in grid.rows]
    least = plain_console(width=UNBOUNDED).measure(_row_table(Grid(grid.head, named))).maximum
    table = _row_table(grid) if least <= width else _column_table(grid)
    table.title, table.title_justify = f"{flown.scenario}, {flown.controller}", "left"
    return table


def _row_table(grid: Grid) -> Table:
    """Return a row for each vehicle."""
    table = Table(box=SIMPLE_HEAD, padding=(0, 1, 0, 0))
    for position, column in enumerate(grid.head):
        justify: JustifyMethod = "left" if position < 2 else "right"
        table.add_column(column, justify=justify, no_wrap=column != "vehicle", overflow="fold")
    for row in grid.rows:
        table.add_row(*row)
    return table


def _column_table(grid: Grid) -> Table:
    """Return a row for each number, after its name."""
    table = Table(box=None, show_header=False, padding=(0, 1, 0, 0))
    for _ in range(2):
        table.add_column(overflow="fold")
    for row in grid.rows:
        for column, cell in zip(grid.head, row, strict=True):
            table.add_row(column.replace("\n", " "), cell)
        table.add_row()
    return table


def mode_words(request: FlightRequest) -> str:
    """Return how a flight counters the downwash: by its mode, and by correction from motion."""
    return MODE_WORDS[request.mode] + (", corrected" if request.correct else "")


def run_notes(runs: Sequence[FlightRun]) -> list[str]:
    """Return zone time and timing of each flight, in lines for a terminal of 80 columns."""
    return [_note(run) for run in runs]


def run_verdicts(runs: Sequence[FlightRun]) -> str:
    """Return the verdicts on the flights in one line."""
    return verdict_line([(mode_words(run.request), run.verdict) for run in runs])


def _note(run: FlightRun) -> str:
    timing, missed = run.timing, counted(run.timing.missed_ticks, "tick")
    latency, tail = significant_digits(timing.latency_p50_ms, 2), significant_digits(timing.latency_p99_ms, 2)
    zone = run.metrics.zone_time_s  # NaN for one vehicle
    inside = f"{significant_digits(zone)} s in the zone, " if math.isfinite(zone) else ""
    return (
        f"{mode_words(run.request)}: {inside}"
        f"{significant_digits(timing.real_time_factor, 2)} x real time, {missed} missed,\n"
        f"    mocap to command {latency} ms in the median, {tail} ms at p99"
    )


def _rows(run: FlightRun) -> list[tuple[str, ...]]:
    numbers = {name: _numbers(run.metrics, one) for name, one in run.metrics.vehicles.items()}
    mode = mode_words(run.request).replace(", ", ",\n")
    return [(mode, name, *map(significant_digits, row)) for name, row in vehicle_rows(numbers)]


def _numbers(metrics: FlightMetrics, one: VehicleMetrics) -> tuple[float, ...]:
    return (
        one.z_rmse_m,
        one.xy_rmse_m,
        one.u1_energy,
        one.u1_energy_above_hover,
        one.u1_max,
        metrics.min_separation_m,
    )
