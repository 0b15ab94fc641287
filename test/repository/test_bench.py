"""Benchmarks as a whole, nothing measured: areas fail alone, and another checkout's rows are next to ours."""

import json
import math
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import osqp
import pytest

import bench
import encounters
import planning
import risk
from area_process import AreaError, read_rows
from compare_checkout import compare_rows, comparison_table, environment_outside
from q2q_planner.experiments.encounter_verdict import EncounterVerdict
from q2q_planner.offline.minimum_snap.minimum_snap import minimum_snap, snap_cost
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints, Waypoint
from roofline import flops_of_a_step
from row import Row

Capture = pytest.CaptureFixture[str]
Rows = dict[str, list[tuple[str, float]]]
"""Names and values of each area."""
PROGRAM = """import json, sys
area, _, file = sys.argv[1:]
rows = {rows}.get(area)
if rows is None:
    sys.exit("Traceback\\nValueError: no luck with " + area)
open(file, "w").write(json.dumps([dict(name=name, value=value, unit="s") for name, value in rows]))
"""
AREA = '"""Area."""\n\n\ndef run() -> None: ...\n'
"""Text of an area's module, which nobody imports: what makes it one."""


def checkout(root: Path, rows: Rows, *failing: str) -> Path:
    """Make a stand-in for a checkout of q2q, whose areas give these rows at once, or fail."""
    for folder in ("benchmarks", "scripts"):
        (root / folder).mkdir(parents=True)
    for area in (*rows, *failing):
        (root / "benchmarks" / f"{area}.py").write_text(AREA)
    program = root / "benchmarks" / "bench.py"
    program.write_text(PROGRAM.format(rows=rows))
    script = root / "scripts" / "bench"
    script.write_text(f'#!/bin/sh\nexec "{sys.executable}" "{program}" "$@"\n')
    script.chmod(0o755)
    return root


def run(
    here: Path, patch: pytest.MonkeyPatch, *words: str
) -> tuple[int, list[tuple[str, float, float | None]]]:
    """Run the benchmarks of a checkout; return the exit status, and name and values of each row."""
    patch.setattr(bench, "HERE", here / "benchmarks")
    file = here / "out" / "rows.json"
    status = bench.main([*words, "--json", str(file)])
    return status, [(one["name"], one["value"], one["baseline"]) for one in json.loads(file.read_text())]


def test_an_area_that_fails_loses_its_own_rows_only(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: Capture
):
    here = checkout(tmp_path, {"air": [("a", 1.0)], "sea": [("b", 2.0)]}, "land")
    assert run(here, monkeypatch) == (1, [("a", 1.0, None), ("b", 2.0, None)])
    assert "without the rows of land" in capfd.readouterr().err


def test_areas_that_all_succeed_end_with_0(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    here = checkout(tmp_path, {"air": [("a", 1.0)], "sea": [("b", 2.0)]})
    assert run(here, monkeypatch) == (0, [("a", 1.0, None), ("b", 2.0, None)])


@pytest.mark.parametrize("words", [[], ["--baseline", "{there}"]])
def test_json_without_a_file_is_alone_on_standard_output(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: Capture, words: list[str]
):
    here = checkout(tmp_path / "here", {"air": [("a", 1.0)], "sea": [("b", 2.0)]}, "land")
    there = checkout(tmp_path / "there", {"air": [("a", 4.0)]})
    monkeypatch.setattr(bench, "HERE", here / "benchmarks")
    assert bench.main([*(word.format(there=there) for word in words), "--json"]) == 1
    printed = capfd.readouterr()
    assert [(one["name"], one["value"]) for one in json.loads(printed.out)] == [("a", 1.0), ("b", 2.0)]
    assert "without the rows of land" in printed.err


def test_an_interrupt_loses_the_rows_of_its_area_only(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: Capture
):
    here = checkout(tmp_path, {"air": [("a", 1.0)], "sea": [("b", 2.0)]})
    rows_of = bench.Bench.rows

    def interrupted_at_sea(self: bench.Bench, area: str) -> list[Row]:
        if area == "sea":
            raise KeyboardInterrupt
        return rows_of(self, area)

    monkeypatch.setattr(bench, "HERE", here / "benchmarks")
    monkeypatch.setattr(bench.Bench, "rows", interrupted_at_sea)
    assert bench.main(["--json"]) == 130
    printed = capfd.readouterr()
    assert [(one["name"], one["value"]) for one in json.loads(printed.out)] == [("a", 1.0)]
    assert printed.err.endswith("bench: interrupted\n")


def test_a_closed_standard_output_is_refused(monkeypatch: pytest.MonkeyPatch, capfd: Capture):
    monkeypatch.setattr(sys, "stdout", None)
    assert bench.main(["simulation", "--json"]) == 2
    assert capfd.readouterr().err.startswith("bench: standard output is closed: redirect it")


def test_what_is_said_with_standard_error_closed_is_no_part_of_the_document(
    monkeypatch: pytest.MonkeyPatch, capfd: Capture
):
    monkeypatch.setattr(sys, "stderr", None)
    assert bench.main(["no_area", "--json"]) == 2
    assert capfd.readouterr() == ("", "")


def test_both_values_are_in_the_table_and_the_rows(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: Capture
):
    here = checkout(tmp_path / "here", {"air": [("tick", 2.0), ("new", 3.0)], "sea": [("b", 7.0)]})
    there = checkout(tmp_path / "there", {"air": [("old", 4.0), ("tick", 8.0)]})
    status, rows = run(here, monkeypatch, "--baseline", str(there))
    assert status == 0
    assert rows == [("tick", 2.0, 8.0), ("new", 3.0, None), ("b", 7.0, None)]
    (line,) = [one for one in capfd.readouterr().out.splitlines() if "tick" in one]
    assert [cell.strip() for cell in line.split("│")[1:-1]] == ["tick", "2", "8", "s", "0.25"]


def test_an_area_that_fails_there_is_reported_in_one_sentence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: Capture
):
    here = checkout(tmp_path / "here", {"air": [("a", 1.0)]})
    there = checkout(tmp_path / "there", {}, "air")
    assert run(here, monkeypatch, "air", "--baseline", str(there)) == (0, [("a", 1.0, None)])
    message = [line for line in capfd.readouterr().err.splitlines() if "failed" in line]
    assert message == [f"bench: in {there}: air failed with status 1: ValueError: no luck with air"]


def test_an_area_that_fails_here_is_not_run_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: Capture
):
    here = checkout(tmp_path / "here", {"sea": [("b", 1.0)]}, "air")
    there = checkout(tmp_path / "there", {"air": [("a", 2.0)], "sea": [("b", 3.0)]})
    assert run(here, monkeypatch, "--baseline", str(there)) == (1, [("b", 1.0, 3.0)])
    assert f"air in {there}" not in capfd.readouterr().err


def test_equal_names_are_matched_below_their_headings_and_in_order():
    ours = [Row(name, value, "s") for name, value in (("ten", 1), ("  cost", 2), ("its", 3), ("its", 4))]
    names = (("two", 10), ("  cost", 20), ("ten", 30), ("  cost", 40), ("its", 50))
    theirs = [Row(name, value, "s") for name, value in names]
    assert [row.baseline for row in compare_rows(ours, theirs)] == [30, 40, 50, None]


def test_another_checkout_sees_no_path_of_ours():
    root = Path("/home/q2q")
    seen = environment_outside(
        root,
        {
            "PATH": "/home/q2q/.venv/bin:/usr/bin:/home/q2q_before/bin",
            "VIRTUAL_ENV": "/home/q2q/.venv",
            "Q2Q_DATA": "/home/q2q/../data",
            "LANG": "C",
            "EMPTY": "",
        },
    )
    kept = {"PATH": "/usr/bin:/home/q2q_before/bin", "Q2Q_DATA": "/home/q2q/../data", "LANG": "C"}
    assert seen == kept | {"EMPTY": ""}


def test_rows_of_other_versions_are_read(tmp_path: Path):
    file = tmp_path / "rows.json"
    file.write_text('[{"name": "a", "value": 1.5, "unit": "s", "colour": "red"}]')
    assert read_rows(file) == [Row("a", 1.5, "s")]
    for broken in ('[{"name": "a"}]', "{", "[1]"):
        file.write_text(broken)
        with pytest.raises(AreaError, match="cannot be read"):
            read_rows(file)


def test_a_value_that_is_not_a_number_is_read_as_such_and_shown(tmp_path: Path):
    file, rows = tmp_path / "rows.json", [Row("p50", math.nan, "ms"), Row("p99", 2.0, "ms")]
    bench._write(rows, file)
    first, second = read_rows(file)
    assert math.isnan(first.value)
    assert (replace(first, value=0.0), second) == (replace(rows[0], value=0.0), rows[1])
    table = comparison_table("live", compare_rows([first, second], [second, first]))
    cells = [[*column.cells] for column in table.columns]
    assert cells == [["p50", "p99"], ["nan", "2"], ["nan", "2"], ["ms", "ms"], ["nan", "1"]]


def test_series_in_which_no_encounter_and_no_flight_counts_have_no_row_of_their_worst():
    late = EncounterVerdict(
        vehicles=2,
        apart=False,
        conditions_hold=False,
        zone_time=0.5,
        silent_time=0.0,
        broken=True,
        clearance=-0.1,
        arrived=None,
        shift=0.0,
    )
    lone = [(row.name, row.value) for row in encounters.rows_of([late])]
    assert ("time in the zone, announced", 0.5) in lone
    met = encounters.rows_of([late, replace(late, conditions_hold=True)])
    extra = [(row.name, row.value) for row in met if row.name not in dict(lone)]
    assert extra == [("  least distance to the zone", -100.0), ("  largest lateral shift", 0.0)]
    assert risk.tube_rows([], risk.TUBE) == [Row("flights", 0, "")]


def test_osqp_is_set_up_once_for_three_axes_and_finds_our_cost(monkeypatch: pytest.MonkeyPatch):
    set_up = []

    class Counted(osqp.OSQP):
        def setup(self, *args: object, **options: object) -> None:
            set_up.append(self)
            super().setup(*args, **options)

    monkeypatch.setattr(osqp, "OSQP", Counted)
    times, points = np.array([0.0, 1.5, 4.0]), np.array([[0.0, 0.0, 1.0], [1.0, -0.5, 2.0], [0.3, 0.4, 1.2]])
    ways = tuple(Waypoint(t, tuple(point)) for t, point in zip(times.tolist(), points.tolist(), strict=True))
    ours = snap_cost(minimum_snap(VehicleWaypoints("cf1", ways), "free"))
    found = planning.cost_by_osqp(planning.coefficient_problem(times, points))
    assert found == pytest.approx(ours, rel=1e-9)  # polished
    assert len(set_up) == 1


def test_a_drone_step_takes_more_operations_among_more_vehicles() -> None:
    """Counted in the plain kernels by numbers that count, in a process of its own."""
    alone, among_ten = flops_of_a_step(1), flops_of_a_step(10)
    assert 100.0 < alone < among_ten < 10.0 * alone
