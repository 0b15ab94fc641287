"""Table and JSON of replayed estimators: the contract of `estimators --json`."""

from collections.abc import Sequence

from rich.table import Table
from rich.text import Text

from q2q_model.counted import counted
from q2q_model.documents.json_file import Json
from q2q_model.plain_console import plain_console
from q2q_sim.experiments.estimators.estimate_errors import ErrorSummary, ReplayedErrors, grouped, summary
from q2q_sim.experiments.estimators.replayed_estimates import DELAY
from q2q_sim.firmware.estimator import DT
from q2q_sim.report.significant_digits import MM

UNBOUNDED = 10_000
"""Width in which no table is cut [characters]."""


def print_whole(table: Table) -> None:
    """Print a table at its full width, also where the output is narrower, as that of a pipe is."""
    wide = plain_console(width=UNBOUNDED)
    plain_console(width=max(plain_console().width, wide.measure(table).maximum)).print(table)


def error_table(found: Sequence[ReplayedErrors]) -> Table:
    """Return the errors over all flights."""
    flights = len({one.flight for one in found})
    made = Table(title=Text(f"Distance from motion capture [mm], {counted(flights, 'flight')}"))
    for column in ("motion capture", "estimator", "median", "95 % interval", "p95", "worst", "diverged"):
        left = column in ("motion capture", "estimator")
        made.add_column(column, justify="left" if left else "right", no_wrap=True)
    for (condition, estimator), one in grouped(found).items():
        made.add_row(condition, estimator, *_cells(one))
    return made


def flight_table_of(found: Sequence[ReplayedErrors]) -> Table:
    """Return the medians of every flight."""
    names = list(dict.fromkeys(one.estimator for one in found))
    made = Table(title=Text("Median of each flight [mm]"))
    for column in ("flight", "motion capture", *names):
        left = column in ("flight", "motion capture")
        made.add_column(column, justify="left" if left else "right", overflow="fold")
    for flight, condition in dict.fromkeys((one.flight, one.condition) for one in found):
        own = {one.estimator: one for one in found if (one.flight, one.condition) == (flight, condition)}
        medians = [f"{MM * summary([own[name]]).median:.1f}" if name in own else "" for name in names]
        made.add_row(Text(flight), condition, *medians)
    return made


def _cells(one: ErrorSummary) -> list[str]:
    between = "" if one.interval is None else "-".join(f"{MM * end:.1f}" for end in one.interval)
    sizes = [f"{MM * size:.1f}" for size in (one.median, one.p95, one.worst)]
    return [sizes[0], between, *sizes[1:], f"{one.diverged} of {one.replays}"]


def errors_json(found: Sequence[ReplayedErrors], draws: int) -> Json:
    """Return {"pooled": [...], "flights": [...]} with one entry for each condition and estimator.

    An error is null where the estimates diverged beyond all numbers.
    """
    pooled: list[Json] = [
        {"condition": condition, "estimator": estimator, **_numbers(one)}
        for (condition, estimator), one in grouped(found).items()
    ]
    flights: list[Json] = [
        {
            "flight": one.flight,
            "condition": one.condition,
            "estimator": one.estimator,
            **_numbers(summary([one])),
        }
        for one in found
    ]
    return {"draws": draws, "delay_s": DELAY * DT, "pooled": pooled, "flights": flights}


def _numbers(one: ErrorSummary) -> dict[str, Json]:
    low, high = one.interval or (None, None)
    return {
        "flights": one.flights,
        "replays": one.replays,
        "samples": one.samples,
        "median_m": one.median,
        "median_low_m": low,
        "median_high_m": high,
        "p95_m": one.p95,
        "worst_m": one.worst,
        "diverged": one.diverged,
    }
