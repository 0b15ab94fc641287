"""The import rules of pyproject.toml refuse what they are to refuse."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest
from fresh_checkout import ROOT

PLANTED = {
    "q2q.planted_tool": "q2q_sim.tools.judge_bags",
    "q2q_model.flights.planted_tool": "q2q_model.tools.scale_jet",
    "q2q_planner.offline.planted_command": "q2q_planner.commands.plan",
    "q2q_control.pid.planted_node": "q2q_control.ros.pid_node",
    "q2q_sim.experiments.planted_tool": "q2q_sim.tools.judge_bags",
    "q2q_sim.node_flights.planted_node": "q2q_sim.ros.flight_director",
    "q2q_model.ros.planted_tool": "q2q_model.tools.scale_jet",
    "q2q_sim.tools.planted_command": "q2q_sim.commands.report",
    "q2q_sim.loop.planted_ros": "rclpy",
    "q2q_sim.tools.planted_ros": "diagnostic_msgs",
    "q2q_sim.monitors.planted_bag": "rosbags",
    "q2q_model.downwash.planted_torch": "torch",
    "q2q_model.signals.planted_layer": "q2q_sim.loop.closed_loop",
    "q2q_planner.offline.planted_layer": "q2q_control.pid.pid",
}
"""Modules that no rule allows to import what they import here."""


def test_each_import_that_breaks_a_rule_is_reported(tmp_path: Path) -> None:
    for package in sorted({name.partition(".")[0] for name in PLANTED}):
        shutil.copytree(
            ROOT / "src" / package / package, tmp_path / package, ignore=shutil.ignore_patterns("__pycache__")
        )
    for module, imported in PLANTED.items():
        path = tmp_path.joinpath(*module.split(".")).with_suffix(".py")
        path.write_text(f"import {imported}\n")
    report = linted(tmp_path)
    for module, imported in PLANTED.items():
        assert f"{module} -> {imported} (l.1)" in report
    assert "No cycles are allowed in q2q_control. " in report  # pid -> ros -> pid


def linted(folder: Path) -> str:
    """Return what lint-imports says of the packages in a folder, each import on one line."""
    if not (command := shutil.which("lint-imports")):
        pytest.skip("lint-imports is not installed: pip install -r requirements/dev.txt")
    found = subprocess.run(
        [command, "--config", str(ROOT / "pyproject.toml"), "--no-cache"],
        cwd=folder,
        env=os.environ | {"PYTHONPATH": str(folder), "COLUMNS": "400"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert found.returncode == 1, found.stderr
    return " ".join(found.stdout.split())
