"""Comparison of the emulated firmware with a folder of tables of the real one."""

import csv
from argparse import Namespace
from pathlib import Path

from q2q_model.documents.json_file import write_json
from q2q_model.writable_places import STDOUT
from q2q_sim.firmware_check.table_rows import CheckTable
from q2q_sim.firmware_check.tolerances import FirmwareVerdict, Tables, compare, tolerance_checks


def run(args: Namespace) -> int:
    """Compare with the tables of the folder; return 1 if a difference is out of its tolerance."""
    verdict = compare(tables_in(args.folder))
    if args.json:
        write_json({name: part._asdict() for name, part in verdict._asdict().items()}, args.json)
    if args.json != STDOUT:
        print(report(verdict))
    return int(not all(one.within for one in tolerance_checks(verdict)))


def tables_in(folder: Path) -> Tables:
    """Return the tables of a folder; raise OSError or ValueError if one is missing or empty."""
    return Tables(
        controllers=_table(folder / "controllers.csv"),
        planner=_table(folder / "planner.csv"),
        supervisor=_table(folder / "supervisor.csv"),
        mixer=_table(folder / "mixer.csv"),
        compensation=_table(folder / "compensation.csv"),
    )


def _table(file: Path) -> CheckTable:
    with file.open(newline="") as text:
        rows = list(csv.DictReader(text))
    if not rows:
        raise ValueError(f"{file.name} has no rows")
    return rows


def report(verdict: FirmwareVerdict) -> str:
    """Return each difference with its tolerance, one on a line."""
    counts = (verdict.controllers.cases, verdict.planner.cases, verdict.supervisor.cases)
    head = "cases: {} of controllers, {} of the planner, {} of the supervisor".format(*counts)
    lines = [
        f"{one.name:40}{one.value:12.4g}  allowed {one.allowed:7g}  {'' if one.within else 'OUT'}".rstrip()
        for one in tolerance_checks(verdict)
    ]
    return "\n".join([head, *lines])
