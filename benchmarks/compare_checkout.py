"""Rows of another checkout next to ours, for a table of before and after from one run on one machine.

Areas run here and there by turns, there by that checkout's own scripts/bench, which sets itself up. Rows are
matched by name; an indented name belongs to the last one before it that is not, and the k-th row of a name to
the k-th there.
"""

import os
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from area_process import Bench
from row import Row

if TYPE_CHECKING:
    from rich.table import Table

ROOT = Path(__file__).resolve().parents[1]
Key = tuple[str, str, int]
"""Name that a row belongs to, its own, and which of that name it is."""


def has_area(checkout: Path, area: str) -> bool:
    """Return whether a checkout has an area."""
    return (checkout / "benchmarks" / f"{area}.py").is_file()


def bench_of(checkout: Path) -> Bench:
    """Return the benchmarks of another checkout."""
    script = checkout.resolve() / "scripts" / "bench"
    return Bench((str(script),), environment_outside(ROOT, os.environ), tables=False, notes=False)


def environment_outside(root: Path, environment: Mapping[str, str]) -> dict[str, str]:
    """Return an environment without what lies inside a checkout: lists of paths lose those entries."""
    kept = {}
    for name, value in environment.items():
        outside = [entry for entry in value.split(os.pathsep) if not _inside(entry, root)]
        if any(outside) or not value:
            kept[name] = os.pathsep.join(outside)
    return kept


def _inside(entry: str, root: Path) -> bool:
    return entry.startswith(os.sep) and Path(os.path.normpath(entry)).is_relative_to(root)


def compare_rows(ours: Sequence[Row], theirs: Sequence[Row]) -> list[Row]:
    """Return our rows with the values of theirs."""
    baseline = {key: row.value for key, row in _keyed(theirs)}
    return [replace(row, baseline=baseline.get(key)) for key, row in _keyed(ours)]


def _keyed(rows: Sequence[Row]) -> Iterator[tuple[Key, Row]]:
    seen: Counter[tuple[str, str]] = Counter()
    heading = ""
    for row in rows:
        heading = heading if row.name.startswith(" ") else row.name
        seen[heading, row.name] += 1
        yield (heading, row.name, seen[heading, row.name]), row


def comparison_table(area: str, rows: Sequence[Row]) -> "Table":
    """Return the table of an area: value here, baseline, and here over baseline."""
    from rich.table import Table

    table = Table(title=area)
    for column in ("figure", "here", "baseline", "unit", "here / baseline"):
        table.add_column(column, justify="left" if column in ("figure", "unit") else "right")
    for row in rows:
        baseline = "-" if row.baseline is None else f"{row.baseline:.4g}"
        ratio = f"{row.value / row.baseline:.3g}" if row.baseline else "-"
        table.add_row(row.name, f"{row.value:.4g}", baseline, row.unit, ratio)
    return table
