"""Figures of a plan are drawn, or refused before anything is written."""

import subprocess
import sys
from pathlib import Path

import pytest
from mpl_toolkits.mplot3d import Axes3D
from section_4_1 import SECTION_4_1

from q2q_model.downwash.jet import PAPER_LAW
from q2q_model.geometry.zone import Cylinder
from q2q_planner.commands.plan import main
from q2q_planner.offline.avoidance.joint_plan import avoid_zones
from q2q_planner.offline.certificate.certificate import certify
from q2q_planner.tools import plan_figures


def test_that_a_zone_can_be_drawn_is_checked_without_the_import_of_drawing() -> None:
    """The check lies within the time of the plan, `cpu_ms`."""
    code = (
        "import sys; from q2q_model.geometry.zone import Cylinder; from q2q_planner.tools import plan_swarm; "
        "plan_swarm.check_drawn(Cylinder(0.3, 1.0)); print('matplotlib' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "False\n"


def test_figures_are_drawn(tmp_path: Path) -> None:
    path, figures = tmp_path / "quick.yaml", tmp_path / "figures"
    path.write_text(
        "vehicles: {cf1: [{t: 0, pos: [-1, 0, 1]}, {t: 3, pos: [1, 0, 1]}],"
        " cf2: [{t: 0, pos: [0, -1, 1.5]}, {t: 3, pos: [0, 1, 1.5]}]}"
    )
    assert main([str(path), "--out", str(tmp_path / "plan.json"), "--figures", str(figures)]) == 0
    drawn = {f"fig{number}.png" for number in (10, 11, 12, 13)} | {"plan_and_zone.png"}
    assert {path.name for path in figures.iterdir()} == drawn


def test_a_zone_that_cannot_be_drawn_is_refused_before_anything_is_written(
    crossing: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, figures = tmp_path / "plan.json", tmp_path / "figures"
    assert main([str(crossing), "--out", str(out), "--eps", "1e-4", "--figures", str(figures)]) == 1
    assert "the safe replanner, whose zone has eps = 0.0001; must be in [0.001," in capsys.readouterr().err
    assert not out.exists()
    assert not figures.exists()


def test_figures_that_cannot_be_written_leave_no_document(
    crossing: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object) -> None:
        raise OSError("no space left")

    monkeypatch.setattr(plan_figures, "draw_all", full)
    words = ["--no-avoid", "--out", str(tmp_path / "plan.json"), "--figures", str(tmp_path / "figures")]
    assert main([str(crossing), *words, "--json"]) == 1
    assert capsys.readouterr().out == ""


def test_the_title_of_the_zone_has_the_time_that_the_certificate_has(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    plan = avoid_zones(SECTION_4_1, Cylinder()).plan
    titles: list[str] = []
    monkeypatch.setattr(Axes3D, "set_title", lambda _, title: titles.append(title))
    plan_figures.draw_all(tmp_path, plan, plan, Cylinder(), PAPER_LAW)
    assert f"t = {certify(plan, Cylinder()).t:.2f} s" in titles[-1]
