"""Out of the zone of a plan with risk, vehicles in their tubes neither touch nor meet strong downwash."""

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import norm

from q2q_model.downwash.correction.residual_process import ResidualProcess
from q2q_model.downwash.interaction_model import pairs_at_rest
from q2q_model.model_files.find_model import find_model
from q2q_model.trajectory.plan_file import load_with_facts
from q2q_planner.commands.plan import main
from q2q_planner.offline.certificate.certified_file import load_plan
from q2q_planner.offline.zones.risk_zone import RiskParams, RiskTube, largest_push, risk_zone

TUBE = RiskTube(0.05, 0.03, 0.004)
STRONG = RiskParams(alpha=0.01, hold=6.0, tube=TUBE)
WEAK = RiskParams(alpha=0.01, hold=2.0, tube=TUBE)
RESIDUAL = ResidualProcess(floor=0.2, slope=0.1)
MODEL = find_model("measured_law").interaction
ZONES = {params: risk_zone(MODEL, params, RESIDUAL) for params in (STRONG, WEAK)}
CROSSING = """
vehicles:
  cf1: [{t: 0, pos: [-1, 0, 1]}, {t: 6, pos: [1, 0, 1]}]
  cf2: [{t: 0, pos: [0, -1, 1.2]}, {t: 6, pos: [0, 1, 1.2]}]
"""

TUBED = ("--tube", "0.05", "0.04")

unit = st.floats(-1.0, 1.0)


def test_downwash_with_its_residual_exceeds_the_thrust_with_the_rest_of_the_risk() -> None:
    push = largest_push(WEAK, RESIDUAL)
    beyond = norm.sf(WEAK.hold, loc=push, scale=RESIDUAL.std(np.array(push)))
    assert beyond == pytest.approx(WEAK.alpha - TUBE.risk, rel=1e-9)


@given(st.tuples(unit, unit, unit), st.tuples(unit, unit, unit), st.sampled_from([STRONG, WEAK]))
def test_errors_within_the_tubes_never_make_a_touch_of_references_out_of_the_zone(
    where: tuple[float, float, float], errors: tuple[float, float, float], params: RiskParams
) -> None:
    across, along, up = where
    touching = params.touch * np.array(where) / max(1.0, float(np.linalg.norm((across, along, up))))
    flat = np.array(errors[:2]) / max(1.0, float(np.hypot(*errors[:2])))
    error = np.array([*(2.0 * TUBE.horizontal * flat), 2.0 * TUBE.vertical * errors[2]])
    assert ZONES[params].signed_distance(touching + error) <= 1e-12  # rounding


def test_the_zone_of_ample_thrust_is_the_touch_and_two_tubes() -> None:
    zone = ZONES[STRONG]
    assert zone.eps == pytest.approx(STRONG.touch + 2.0 * TUBE.horizontal, rel=1e-12)
    assert zone.d == pytest.approx(STRONG.touch + 2.0 * TUBE.vertical, rel=1e-12)
    corner = np.array([STRONG.touch, 0.0, 0.0]) / np.sqrt(2.0)
    corner[2] = corner[0]
    corner += [2.0 * TUBE.horizontal, 0.0, 2.0 * TUBE.vertical]
    assert zone.signed_distance(corner) == pytest.approx(0.0, abs=1e-3)  # TANGENTS


def test_strong_downwash_is_in_the_zone_of_weak_thrust_wherever_the_tubes_lead() -> None:
    across, gap = np.meshgrid(np.linspace(0.0, 0.4, 81), np.linspace(0.0, 1.4, 141))
    rel_pos = np.stack([across, np.zeros_like(gap), gap], axis=-1)
    push = np.abs(MODEL.acceleration(rel_pos, pairs_at_rest(rel_pos))[..., 2])
    strong = push >= largest_push(WEAK, RESIDUAL)
    assert strong.sum() > 100
    for side in (-1.0, 1.0):
        led = side * rel_pos[strong] + side * np.array([2.0 * TUBE.horizontal, 0.0, 2.0 * TUBE.vertical])
        assert (ZONES[WEAK].signed_distance(led) <= 0.0).all()


def test_risks_that_cannot_be_kept_are_refused() -> None:
    with pytest.raises(ValueError, match=r"risk = 0.004: the tube alone is left with probability 0.004"):
        RiskParams(alpha=0.004, hold=2.0, tube=TUBE)
    with pytest.raises(ValueError, match=r"hold = 0; must be in \(0, 100\]"):
        RiskParams(alpha=0.01, hold=0.0, tube=TUBE)
    with pytest.raises(ValueError, match=r"tube: vertical = -0.1; must be in \[0, 2\]"):
        RiskTube(0.1, -0.1, 0.005)
    with pytest.raises(ValueError, match=r"2.51 deviations of the residual without downwash are 0.50 m/s\^2"):
        largest_push(RiskParams(alpha=0.01, hold=0.3, tube=TUBE), RESIDUAL)


def test_a_plan_at_a_risk_is_certified_and_says_what_it_rests_on(tmp_path: Path) -> None:
    path, out, facts = tmp_path / "crossing.yaml", tmp_path / "plan.json", tmp_path / "facts.json"
    path.write_text(CROSSING)
    asked = ["--risk", "0.02", "--tube", "0.05", "0.04", "--vehicle", "crazyflie_2_1", "--json", str(facts)]
    assert main([str(path), "--out", str(out), *asked]) == 0
    known, output = load_with_facts(out)[1], json.loads(facts.read_text())
    assert load_plan(out).certified
    assert output["certified"] is True
    assert output["risk"] == 0.02
    assert output["swarm_risk"] == 0.04  # Boole, two vehicles
    assert (output["tube_horizontal_m"], output["tube_vertical_m"]) == (0.05, 0.04)
    assert known.zone.startswith("risk 0.02 a vehicle: 0.14 m apart, measured_law below")
    assert known.zone.endswith("tube 0.05 m horizontally and 0.04 m vertically at 0.01")


def test_a_plan_through_the_zone_has_no_risk_of_the_swarm(tmp_path: Path) -> None:
    path, out, facts = tmp_path / "crossing.yaml", tmp_path / "plan.json", tmp_path / "facts.json"
    path.write_text(CROSSING)
    asked = ["--risk", "0.02", *TUBED, "--vehicle", "crazyflie_2_1", "--json", str(facts), "--no-avoid"]
    assert main([str(path), "--out", str(out), *asked]) == 0
    output = json.loads(facts.read_text())
    assert (output["certified"], output["risk"], output["swarm_risk"]) == (False, 0.02, None)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--risk", "0.7", *TUBED], "risk = 0.7; must be in (0, 0.5]"),
        (["--risk", "nan", *TUBED], "tube: risk = nan; must be in [0, 0.5]"),
        (
            ["--risk", "0.01", "--model", "measured_law", "--cut", "0.5"],
            "--cut and --risk both choose the zone",
        ),
        (["--risk", "0.01", "--tube-risk", "0.005"], "--risk 0.01 needs --tube"),
        (["--risk", "0.01", *TUBED, "--vehicle", "crazyflie_2_1", "--hold", "6.46"], "needs 0.44"),
        (
            ["--risk", "0.01", *TUBED, "--hold", "50"],
            "--hold 50: crazyflie_2_0 has a thrust margin of 3.12 m/s^2",
        ),
        (["--risk", "0.01", *TUBED, "--eps", "0.5"], "--eps and --risk both choose the zone"),
        (["--tube", "0.1", "0.1"], "--tube needs --risk"),
        (["--touch", "0.3"], "--touch needs --risk"),
    ],
)
def test_options_that_do_not_fit_are_refused(
    options: list[str], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "crossing.yaml"
    path.write_text(CROSSING)
    assert main([str(path), "--out", str(tmp_path / "plan.json"), *options]) == 1
    assert message in capsys.readouterr().err
