"""Compare the emulated firmware with tables of the real one: `firmware_check FOLDER`.

Ends with 1 where a figure is out of its tolerance.

FOLDER holds controllers.csv, planner.csv, supervisor.csv, mixer.csv and compensation.csv, computed with the
firmware's own C code.
"""

import csv
import json
import sys
from collections.abc import Sequence
from pathlib import Path

from q2q_model.tools.command_line import CommandLine, without_ros

from q2q_sim.fidelity.cases import Table
from q2q_sim.fidelity.verdict import Tables, Verdict, compare, figures

EXAMPLE = """  ros2 run q2q_sim firmware_check ../shared/data/firmware
  ros2 run q2q_sim firmware_check ../shared/data/firmware --json"""
STDOUT = "-"


def main(arguments: Sequence[str] | None = None) -> int:
    """Compare with the tables the command line names; return the exit status."""
    asked = parser().parse_args(without_ros(arguments))
    try:
        verdict = compare(tables_in(asked.folder))
    except (ValueError, KeyError, OSError) as refusal:
        print(f"firmware_check: {asked.folder}: {refusal}", file=sys.stderr)
        return 2
    words = json.dumps({name: part._asdict() for name, part in verdict._asdict().items()}, indent=1)
    if asked.json not in {None, STDOUT}:
        Path(asked.json).write_text(words + "\n")
    print(words if asked.json == STDOUT else report(verdict))
    return int(not all(one.within for one in figures(verdict)))


def parser() -> CommandLine:
    """Return the parser of the command line."""
    made = CommandLine("firmware_check", __doc__, EXAMPLE)
    made.add_argument("folder", type=Path, metavar="FOLDER", help="folder with the five tables")
    made.add_argument(
        "--json", nargs="?", const=STDOUT, metavar="FILE", help="print JSON instead, or write it to FILE"
    )
    return made


def tables_in(folder: Path) -> Tables:
    """Return the tables of a folder; raise OSError or ValueError where one is missing or empty."""
    return Tables(
        controllers=_table(folder / "controllers.csv"),
        planner=_table(folder / "planner.csv"),
        supervisor=_table(folder / "supervisor.csv"),
        mixer=_table(folder / "mixer.csv"),
        compensation=_table(folder / "compensation.csv"),
    )


def _table(file: Path) -> Table:
    with file.open(newline="") as text:
        rows = list(csv.DictReader(text))
    if not rows:
        raise ValueError(f"{file.name} has no rows")
    return rows


def report(verdict: Verdict) -> str:
    """Return each figure beside its tolerance, one a line."""
    counts = (verdict.controllers.cases, verdict.planner.cases, verdict.supervisor.cases)
    head = "cases: {} of controllers, {} of the planner, {} of the supervisor".format(*counts)
    lines = [
        f"{one.name:40}{one.value:12.4g}  allowed {one.allowed:7g}  {'' if one.within else 'OUT'}".rstrip()
        for one in figures(verdict)
    ]
    return "\n".join([head, *lines])


if __name__ == "__main__":
    sys.exit(main())
