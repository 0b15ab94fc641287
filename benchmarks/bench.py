"""Run the benchmarks: `scripts/bench [AREA...] [--json [FILE]] [--plots FOLDER] [--baseline CHECKOUT]`.

Each area is a module of this folder with `run() -> list[Row]`; its references are measured in the same run.
Several areas run one after the other, each in a process of its own; one that fails loses its own rows only.
`--plots` runs the area growth and draws it. `--baseline` runs each area in that checkout, too, and shows both
values.
"""

import sys
from argparse import Namespace
from collections.abc import Sequence
from contextlib import redirect_stdout
from dataclasses import asdict
from difflib import get_close_matches
from importlib import import_module
from pathlib import Path

from area_process import AreaError, Bench
from compare_checkout import bench_of, compare_rows, comparison_table, has_area
from q2q_model.commands.argument_types import add_printed_json, output_folder
from q2q_model.commands.command_line import CLOSED_OUTPUT, CommandLine, open_standard_error
from q2q_model.documents.json_file import text_stream, write_json
from q2q_model.writable_places import STDOUT
from row import Row

HERE = Path(__file__).parent
DRAWN = "growth"
"""Area whose `run` takes a folder for its figures."""
EXAMPLE = """  scripts/bench simulation
  scripts/bench --json after.json --baseline ../q2q_before"""


def areas() -> list[str]:
    """Return the names of the areas."""
    return sorted(path.stem for path in HERE.glob("*.py") if "\ndef run(" in path.read_text())


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the chosen areas; return the exit status, 1 if one failed."""
    open_standard_error()
    args = _parser().parse_args(arguments)
    if refused := _refusal(args):
        print(f"bench: {refused}", file=sys.stderr)
        return 2
    chosen = args.area or ([] if args.plots else areas())
    if args.plots and DRAWN not in chosen:
        chosen.append(DRAWN)
    try:
        if len(chosen) > 1 or args.baseline:
            return _run_apart(chosen, args)
        with redirect_stdout(text_stream(args.json)):
            rows = _run(chosen[0], args.plots)
        _write(rows, args.json)
    except KeyboardInterrupt:
        print("bench: interrupted", file=sys.stderr)
        return 130
    return 0


def _parser() -> CommandLine:
    made = CommandLine("bench", __doc__, EXAMPLE)
    made.add_argument("area", nargs="*", help=f"areas to run (default: all of {', '.join(areas())})")
    add_printed_json(
        made, "print the rows as JSON (other text then goes to standard error), or write them to FILE"
    )
    made.add_argument(
        "--plots",
        type=output_folder,
        metavar="FOLDER",
        help=f"run the area {DRAWN} and draw its figures into this folder",
    )
    made.add_argument(
        "--baseline",
        type=Path,
        metavar="CHECKOUT",
        help="folder of another checkout of q2q, whose scripts/bench runs each area in turn with this one",
    )
    return made


def _refusal(args: Namespace) -> str | None:
    """Return why the arguments cannot be carried out."""
    if sys.stdout is None:
        return CLOSED_OUTPUT
    if str(args.json) in areas():
        return f"`--json {args.json}` names a file: give the area first, as in `bench {args.json} --json`"
    for area in args.area:
        if area not in areas():
            near = get_close_matches(area, areas(), n=1)
            hint = f"did you mean {near[0]}?" if near else f"there are {', '.join(areas())}"
            return f"no area {area!r}; {hint}"
    if args.baseline and not (args.baseline / "scripts" / "bench").is_file():
        return f"no scripts/bench in {args.baseline}: --baseline takes the folder of a checkout of q2q"
    return None


def _run_apart(chosen: Sequence[str], args: Namespace) -> int:
    """Run areas in processes of their own, and those of another checkout; keep what there is."""
    rows: list[Row] = []
    failed = []
    printed = args.json == STDOUT
    try:
        for area in chosen:
            try:
                with redirect_stdout(text_stream(args.json)):
                    rows += _rows_apart(area, args)
            except AreaError as error:
                print(f"bench: {error}", file=sys.stderr)
                failed.append(area)
            if not printed:
                _write(rows, args.json)
    finally:  # interrupted, too
        if printed:
            _write(rows, args.json)
    if failed:
        print(f"bench: without the rows of {', '.join(failed)}, which failed", file=sys.stderr)
    return int(bool(failed))


def _rows_apart(area: str, args: Namespace) -> list[Row]:
    """Run an area in a process of its own, and in another checkout; return the rows. Raises AreaError."""
    plots = ("--plots", str(args.plots)) if args.plots and area == DRAWN else ()
    tables = not (args.baseline or args.json == STDOUT)
    ours = Bench((sys.executable, str(HERE / "bench.py"), *plots), tables=tables).rows(area)
    return _compared(area, ours, args.baseline) if args.baseline else ours


def _compared(area: str, ours: list[Row], checkout: Path) -> list[Row]:
    """Run the area in another checkout; print both values of each row and return the rows."""
    from rich.console import Console

    theirs: list[Row] = []
    if has_area(checkout, area):
        print(f"bench: {area} in {checkout} ...", file=sys.stderr)
        try:
            theirs = bench_of(checkout).rows(area)
        except AreaError as error:
            print(f"bench: in {checkout}: {error}", file=sys.stderr)
    both = compare_rows(ours, theirs)
    Console().print(comparison_table(area, both))
    return both


def _write(rows: Sequence[Row], file: Path | None) -> None:
    if file:
        write_json([asdict(row) for row in rows], file)


def _run(area: str, plots: Path | None) -> list[Row]:
    from rich.console import Console
    from rich.table import Table

    print(f"bench: {area} ...", file=sys.stderr)
    made = import_module(area).run
    rows: list[Row] = made(plots) if plots else made()
    table = Table(title=area)
    for column in ("figure", "value", "unit", "reference", "ratio"):
        table.add_column(column, justify="right" if column in ("value", "ratio") else "left")
    for row in rows:
        ratio = "-" if row.ratio is None else f"{row.ratio:.3g}"
        table.add_row(row.name, f"{row.value:.4g}", row.unit, row.reference or "-", ratio)
    Console().print(table)
    return rows


if __name__ == "__main__":
    sys.exit(main())
