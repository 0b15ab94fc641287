"""Say flights as a table, one row a vehicle and mode, as the paper's Table 6."""

from collections.abc import Sequence

from rich.table import Table

from q2q_sim.tools.flight import FlightRun
from q2q_sim.tools.page import Grid
from q2q_sim.tools.run_json import finite

MODE_WORDS = {
    "ignoring": "ignoring",
    "aware": "aware, limited",
    "aware_unlimited": "aware, no limit",
}
HEAD = (
    "mode",
    "vehicle",
    "z RMSE [m]",
    "xy RMSE [m]",
    "U1 energy [N²s]",
    "above hover",
    "max U1 [N]",
    "separation [m]",
    "in zone [s]",
    "x real time",
    "missed",
)


def run_grid(runs: Sequence[FlightRun]) -> Grid:
    """Return the cells of the table."""
    return Grid(HEAD, [row for run in runs for row in _rows(run)])


def run_table(runs: Sequence[FlightRun]) -> Table:
    """Return the table for a terminal."""
    table = Table(title=f"{runs[0].request.scenario}, {runs[0].request.controller}")
    for position, column in enumerate(HEAD):
        table.add_column(column, justify="left" if position < 2 else "right")
    for run in runs:
        for row in _rows(run):
            table.add_row(*row)
        table.add_section()
    return table


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
            _number(run.metrics.zone_time_s, 2),
            _number(run.timing.real_time_factor, 1),
            str(run.timing.missed_ticks),
        )
        for name, one in run.metrics.vehicles.items()
    ]


def _number(value: float | None, digits: int) -> str:
    known = finite(value)
    return "-" if known is None else f"{known:.{digits}f}"
