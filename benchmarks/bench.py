"""Run the benchmarks: `scripts/bench [AREA...] [--json FILE] [--plots FOLDER]`.

Each area is a module of this folder with `run() -> list[Row]`; its references are measured in the same run.
`--plots` runs the area growth and draws it.
"""

import json
import sys
from collections.abc import Sequence
from dataclasses import asdict
from difflib import get_close_matches
from importlib import import_module
from pathlib import Path

from q2q_model.commands.command_line import CommandLine
from row import Row

HERE = Path(__file__).parent
NOT_AREAS = ("bench", "neural_trajectory", "roofline", "row", "tick_profile")
DRAWN = "growth"
"""Area whose `run` takes a folder for its figures."""


def areas() -> list[str]:
    """Return the names of the areas."""
    return sorted(path.stem for path in HERE.glob("*.py") if path.stem not in NOT_AREAS)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the chosen areas; return the exit status."""
    made = CommandLine("bench", __doc__, "  scripts/bench simulation")
    made.add_argument("area", nargs="*", help=f"areas to run (default: all of {', '.join(areas())})")
    made.add_argument("--json", type=Path, help="write the rows to this file")
    made.add_argument("--plots", type=Path, metavar="FOLDER", help=f"run {DRAWN} and draw its figures there")
    args = made.parse_args(arguments)
    for area in args.area:
        if area not in areas():
            near = get_close_matches(area, areas(), n=1)
            hint = f"did you mean {near[0]}?" if near else f"there are {', '.join(areas())}"
            print(f"bench: no area {area!r}; {hint}", file=sys.stderr)
            return 2
    chosen = args.area or ([] if args.plots else areas())
    if args.plots and DRAWN not in chosen:
        chosen.append(DRAWN)
    rows = [row for area in chosen for row in _run(area, args.plots if area == DRAWN else None)]
    if args.json:
        args.json.parent.mkdir(parents=True, exist_ok=True)
        args.json.write_text(json.dumps([asdict(row) for row in rows], indent=1) + "\n")
    return 0


def _run(area: str, plots: Path | None) -> list[Row]:
    from rich.console import Console
    from rich.table import Table

    print(f"bench: {area} ...", file=sys.stderr)
    made = import_module(area).run
    rows: list[Row] = made(plots) if plots else made()
    table = Table(title=area)
    for column in ("figure", "value", "unit", "beside", "ratio"):
        table.add_column(column, justify="right" if column in ("value", "ratio") else "left")
    for row in rows:
        ratio = "-" if row.ratio is None else f"{row.ratio:.3g}"
        table.add_row(row.name, f"{row.value:.4g}", row.unit, row.reference or "-", ratio)
    Console().print(table)
    return rows


if __name__ == "__main__":
    sys.exit(main())
