"""The command line of the planner: its numbers, its files, its refusals."""

import json
from pathlib import Path

import numpy as np
import pytest

from q2q_planner import plan_file
from q2q_planner.tools.plan import main

SECTION_4_1 = """
vehicles:
  cf1: [{t: 0, pos: [-1, 0, 0]}, {t: 20, pos: [0, 0, 2.5]}, {t: 50, pos: [1, 0, 0]}]
  cf2: [{t: 0, pos: [0, -1, 0]}, {t: 30, pos: [0, 0, 2.0]}, {t: 50, pos: [0, 1, 0]}]
"""


@pytest.fixture
def waypoints(tmp_path: Path) -> Path:
    path = tmp_path / "way points.yaml"
    path.write_text(SECTION_4_1)
    return path


def test_section_4_1_is_certified_at_a_few_per_cent_more_than_the_infimum(waypoints: Path) -> None:
    out, numbers = waypoints.with_name("plan.json"), waypoints.with_name("cost.json")
    assert main([str(waypoints), "--out", str(out), "--json", str(numbers)]) == 0
    found = json.loads(numbers.read_text())
    assert set(found) == {"snap_cost", "snap_infimum", "certified", "clearance_m", "cpu_ms", "vehicles"}
    assert found["snap_infimum"] == pytest.approx(1.02115e-3, rel=5e-6)  # as many digits as are known
    assert found["snap_cost"] <= 1.04 * found["snap_infimum"]
    assert found["certified"] is True
    assert found["clearance_m"] > 0.0
    assert plan_file.load(out).certified


def test_without_avoidance_the_same_waypoints_are_said_to_be_inside(
    waypoints: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = waypoints.with_name("plan.json")
    assert main([str(waypoints), "--out", str(out), "--no-avoid"]) == 0
    assert "NOT out of the zone" in capsys.readouterr().out
    assert not plan_file.load(out).certified


def test_uploads_hold_the_plans_own_polynomials(waypoints: Path) -> None:
    out, folder = waypoints.with_name("plan.json"), waypoints.with_name("uploads")
    assert main([str(waypoints), "--out", str(out), "--upload", str(folder)]) == 0
    plan = plan_file.load(out)
    lines = (folder / "cf2.csv").read_text().splitlines()
    assert lines[0].startswith("Duration,x^0,x^1")
    assert lines[0].endswith(",yaw^7")
    rows = np.array([[float(word) for word in line.split(",")] for line in lines[1:]])
    np.testing.assert_array_equal(rows[:, 0], plan.trajectories[1].durations)
    np.testing.assert_array_equal(rows[:, 1:].reshape(-1, 4, 8), plan.trajectories[1].coefficients)


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        (SECTION_4_1.replace("[0, 0, 2.0]", "[0, .nan, 2.0]"), "cf2, waypoint 1"),
        (SECTION_4_1.replace("t: 30", "t: 60"), "cf2, waypoint 2"),
        ("vehicles: 3", "vehicles"),
        ("{", "plan:"),
    ],
)
def test_wrong_waypoints_are_refused_in_words(
    wrong: str, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "wrong.yaml"
    path.write_text(wrong)
    assert main([str(path), "--out", str(tmp_path / "plan.json")]) == 1
    assert said in capsys.readouterr().err
    assert not (tmp_path / "plan.json").exists()
