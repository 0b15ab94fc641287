"""The zone of a plan is a level set of a learned downwash, or chosen by what it spares."""

import json
from pathlib import Path

import numpy as np
import pytest

from q2q_model.downwash.jet import PAPER_LAW
from q2q_model.signals.values import Array
from q2q_model.trajectory.plan_file import load, load_with_facts
from q2q_model.trajectory.polynomials import SwarmPlan
from q2q_model.vehicle.altitude_loop import PAPER_LOOP
from q2q_planner.commands.plan import main
from q2q_planner.offline.certificate.certified_file import load_plan
from q2q_planner.offline.zones.altitude_response import altitude_rms
from q2q_planner.offline.zones.downwash_zone import STEP


def test_the_zone_is_chosen_by_what_it_spares(
    crossing: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, facts = tmp_path / "plan.json", tmp_path / "facts.json"
    asked = [str(crossing), "--out", str(out), "--model", "paper_law", "--cut"]
    assert main([*asked, "0.5", "--json", str(facts), "--initial-guesses", "1"]) == 0
    output = json.loads(facts.read_text())
    assert output["certified"] is True
    assert (
        output["snap_cost"] <= 1.1 * output["snap_infimum"]
    )  # half of the downwash costs less than 88 % of it
    assert "avoids 5" in capsys.readouterr().out  # 50 to 60 %
    assert main([*asked, "1.5"]) == 1
    assert "cut = 1.5; must be above 0 and below 1" in capsys.readouterr().err
    assert main([str(crossing), "--out", str(out), "--cut", "0.5"]) == 1
    assert "--cut 0.5 needs --model" in capsys.readouterr().err


def test_a_level_set_of_a_learned_downwash_is_a_zone(crossing: Path, tmp_path: Path) -> None:
    out = tmp_path / "plan.json"
    zone = ["--model", "paper_law", "--threshold", "0.1"]
    assert main([str(crossing), *zone, "--out", str(out)]) == 0
    assert load_plan(out).certified


def test_a_zone_that_ends_at_the_range_of_its_model_says_so(crossing: Path, tmp_path: Path) -> None:
    words = []
    for threshold in ("0.3", "1.5"):
        asked = ["--model", "measured_law", "--threshold", threshold, "--no-avoid"]
        assert main([str(crossing), *asked, "--out", str(tmp_path / "plan.json")]) == 0
        words.append(load_with_facts(tmp_path / "plan.json")[1].zone)
    left = 2.5 * np.exp(-0.95 * (1.2 - 0.4))
    assert words[0].endswith(f", down to 1.2 m, the range of the model, where it is still {left:.2f} m/s^2")
    assert words[1] == "level set of measured_law at 1.5 m/s^2"


def test_the_reduction_that_is_reported_is_that_of_the_plan_that_is_written_also_from_a_warm_start(
    crossing: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    other, out = tmp_path / "other.json", tmp_path / "plan.json"
    assert main([str(crossing), "--eps", "0.5", "--d", "1.5", "--out", str(other)]) == 0
    asked = ["--model", "paper_law", "--cut", "0.5", "--initial-guesses", "1", "--warm-start", str(other)]
    assert main([str(crossing), *asked, "--out", str(out)]) == 0
    free, avoiding = (_predicted_rms(plan) for plan in (_free_plan(crossing, tmp_path), load(out)))
    reduction = 100.0 * float((1.0 - avoiding / free).min())
    for words in (capsys.readouterr().out, load_with_facts(out)[1].zone):
        assert f"avoids {reduction:.1f} % of the predicted height error" in words


def _free_plan(crossing: Path, folder: Path) -> SwarmPlan:
    assert main([str(crossing), "--no-avoid", "--out", str(folder / "free.json")]) == 0
    return load(folder / "free.json")


def _predicted_rms(plan: SwarmPlan) -> Array:
    t = np.arange(0.0, plan.duration, STEP)
    pos = np.stack([curve.at(t)[:, :3] for curve in plan.trajectories], axis=1)
    return altitude_rms(pos, STEP, PAPER_LAW, PAPER_LOOP)
