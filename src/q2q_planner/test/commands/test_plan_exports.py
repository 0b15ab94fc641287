"""Tables of a plan, and its upload for Crazyswarm2, hold the plan."""

import csv
from pathlib import Path

import numpy as np
import pytest
from numpy.polynomial import Polynomial

from q2q_model.trajectory.plan_file import load
from q2q_planner.commands.plan import main
from q2q_planner.offline.minimum_snap.minimum_snap import minimum_snap_plan
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints, Waypoint
from q2q_planner.tools.export import write_samples


def test_a_table_in_a_new_folder_holds_the_plan(crossing: Path, tmp_path: Path) -> None:
    out, table = tmp_path / "plan.json", tmp_path / "new" / "folder" / "plan.csv"
    assert main([str(crossing), "--out", str(out), "--csv", str(table)]) == 0
    plan = load(out)
    with table.open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 2 * 5001
    row = next(row for row in rows if row["t"] == "25.0" and row["name"] == "cf2")
    assert [float(row[axis]) for axis in "xyz"] == pytest.approx(
        plan.trajectories[1].at(np.asarray(25.0))[:3], abs=1e-12
    )


@pytest.mark.parametrize("end", [0.07, 1.11, 1.1, 1.115, 0.1 + 0.2])  # 1.11 / 0.01 is 111.00000000000001
def test_a_table_has_no_instant_twice(end: float, tmp_path: Path) -> None:
    ways = Waypoint(0.0, (0.0, 0.0, 1.0)), Waypoint(end, (0.1, 0.0, 1.0))
    write_samples(tmp_path / "plan.csv", minimum_snap_plan([VehicleWaypoints("cf1", ways)]))
    with (tmp_path / "plan.csv").open() as file:
        times = [float(row["t"]) for row in csv.DictReader(file)]
    assert times[-1] == end
    assert np.diff(times)[:-1] == pytest.approx(0.01, abs=1e-9)
    assert 1e-3 < times[-1] - times[-2] < 0.01 + 1e-9


def test_an_upload_read_as_crazyswarm2_does_flies_the_plan(crossing: Path, tmp_path: Path) -> None:
    """crazyflie_py: loadtxt, then one polynomial an axis and piece, in time since the piece's start."""
    out, uploads = tmp_path / "plan.json", tmp_path / "uploads"
    assert main([str(crossing), "--out", str(out), "--upload", str(uploads)]) == 0
    plan = load(out)
    for name, trajectory in zip(plan.names, plan.trajectories, strict=True):
        assert (uploads / f"{name}.csv").read_text().startswith("Duration,x^0,x^1")
        data = np.loadtxt(uploads / f"{name}.csv", delimiter=",", skiprows=1, usecols=range(33), ndmin=2)
        begun = 0.0
        for row in data:
            for t in np.linspace(begun, begun + row[0], 7):
                axes = [Polynomial(row[1 + 8 * axis : 9 + 8 * axis]) for axis in range(4)]
                for derivative, tolerance in ((0, 1e-12), (1, 1e-12), (2, 1e-10)):  # sums in another order
                    flown = [
                        axis.deriv(derivative)(t - begun) if derivative else axis(t - begun) for axis in axes
                    ]
                    assert flown == pytest.approx(trajectory.at(np.asarray(t), derivative), abs=tolerance)
            begun += row[0]
        assert begun == pytest.approx(plan.duration, abs=1e-12)


def test_more_waypoints_than_a_crazyflie_holds_are_refused_before_the_search(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "long.yaml"
    rows = ", ".join(f"{{t: {2 * k}, pos: [{k % 2}, 0, 1]}}" for k in range(33))
    path.write_text(f"vehicles: {{cf1: [{rows}]}}")
    monkeypatch.delattr("q2q_planner.tools.plan_swarm.make_plan")
    arguments = ["--out", str(tmp_path / "plan.json"), "--upload", str(tmp_path / "uploads")]
    assert main([str(path), *arguments]) == 1
    assert "cf1: 32 pieces; must be at most 31, a Crazyflie's memory" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == [path]


def test_a_plan_cut_into_more_pieces_than_a_crazyflie_holds_leaves_no_file(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "crossings.yaml"
    rows = [
        ", ".join(f"{{t: {20 * k}, pos: [{x * (-1) ** k}, {y * (-1) ** k}, {z}]}}" for k in range(count))
        for x, y, z, count in ((1, 0, 1.0, 8), (0, 1, 1.6, 2))
    ]
    path.write_text(f"vehicles: {{cf1: [{rows[0]}], cf2: [{rows[1]}]}}")
    arguments = ["--out", str(tmp_path / "plan.json"), "--csv", str(tmp_path / "plan.csv")]
    assert main([str(path), *arguments, "--upload", str(tmp_path / "uploads")]) == 1
    assert "cf1: 35 pieces; must be at most 31, a Crazyflie's memory" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == [path]
    assert main([str(path), *arguments]) == 0


@pytest.mark.parametrize("option", ["--out", "--csv", "--json"])
def test_an_output_that_would_be_a_vehicle_s_upload_is_refused(
    option: str, crossing: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    uploads = tmp_path / "uploads"
    arguments = ["--out", str(tmp_path / "plan.json"), "--upload", str(uploads)]
    assert main([str(crossing), *arguments, option, str(uploads / "cf2.csv")]) == 1
    assert f"--upload writes {uploads / 'cf2.csv'} for cf2" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == [crossing]
