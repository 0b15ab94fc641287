"""`plan` plans what a waypoint file asks for, and says whether it is certified."""

import json
from pathlib import Path

import pytest
from section_4_1 import SECTION_4_1

from q2q_model.trajectory.plan_file import load, load_with_facts
from q2q_planner.commands.plan import main
from q2q_planner.offline.certificate import certificate
from q2q_planner.offline.minimum_snap.flight_limits import FlightLimits
from q2q_planner.tools.waypoint_file import read_waypoints


def test_a_file_of_section_4_1_is_read_as_its_waypoints(crossing: Path) -> None:
    assert read_waypoints(crossing, FlightLimits(), "stop_and_go") == SECTION_4_1


def test_without_avoidance_it_writes_the_infimum_and_says_not_certified(
    crossing: Path, tmp_path: Path
) -> None:
    out, facts = tmp_path / "plan.json", tmp_path / "facts.json"
    assert main([str(crossing), "--no-avoid", "--out", str(out), "--json", str(facts)]) == 0
    output = json.loads(facts.read_text())
    assert set(output) == {"snap_cost", "snap_infimum", "certified", "clearance_m", "cpu_ms", "vehicles"}
    assert output["snap_cost"] == output["snap_infimum"] == pytest.approx(1.02115e-3, rel=2e-6)
    assert output["certified"] is False
    assert output["clearance_m"] < 0.0
    assert output["vehicles"] == 2
    assert load(out).names == ("cf1", "cf2")


def test_json_without_a_file_is_alone_on_standard_output(
    crossing: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "plan.json"
    assert main([str(crossing), "--no-avoid", "--out", str(out), "--json"]) == 0
    printed = capsys.readouterr()
    assert json.loads(printed.out)["snap_cost"] == pytest.approx(1.02115e-3, rel=2e-6)
    assert printed.err.startswith(f"{out}: 2 vehicles, ")


def test_a_plan_too_large_for_the_proof_is_said_to_be_that(
    crossing: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(certificate, "MOST_STRETCHES", 1)
    assert main([str(crossing), "--no-avoid", "--out", str(tmp_path / "plan.json")]) == 0
    output = capsys.readouterr().out
    assert "NOT proven: 3 pieces of 2 vehicles have 3 stretches of pairs, more than 1 (" in output


def test_a_hover_costs_nothing_and_is_planned(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, out = tmp_path / "hover.yaml", tmp_path / "plan.json"
    path.write_text("vehicles: {cf1: [{t: 0, pos: [0, 0, 0.5]}, {t: 20, pos: [0, 0, 0.5]}]}")
    assert main([str(path), "--out", str(out)]) == 0
    assert capsys.readouterr().out.splitlines()[:2] == [f"{out}: 1 vehicle, 20 s", "  snap cost 0"]
    assert load(out).duration == pytest.approx(20.0)


def test_with_avoidance_it_is_certified_in_plan_file_and_json(crossing: Path, tmp_path: Path) -> None:
    out, facts = tmp_path / "plan.json", tmp_path / "facts.json"
    assert main([str(crossing), "--out", str(out), "--json", str(facts)]) == 0
    output = json.loads(facts.read_text())
    plan, known = load_with_facts(out)
    assert output["certified"] is plan.certified is True
    assert output["snap_infimum"] < output["snap_cost"] <= 1.04 * output["snap_infimum"]
    assert output["clearance_m"] == known.clearance > 0.0
    assert known.zone == "cylinder eps 0.1 m, d 1.1 m"


def test_waypoints_without_times_get_them(tmp_path: Path) -> None:
    path, out = tmp_path / "untimed.yaml", tmp_path / "plan.json"
    path.write_text("vehicles: {cf1: [{pos: [0, 0, 1]}, {pos: [3, 0, 1]}]}")
    assert main([str(path), "--speed", "1.0", "--out", str(out)]) == 0
    assert load(out).duration == pytest.approx(35.0 / 16.0 * 3.0, abs=0.011)  # a tick


UNTIMED = "vehicles: {cf1: [{pos: [0, 0, 1]}, {pos: [3, 0, 1]}, {pos: [3, 2, 1]}]}"
HASTY = "vehicles: {cf1: [{t: 0, pos: [0, 0, 1]}, {t: 1.9, pos: [0, 0, 3]}]}"


@pytest.mark.parametrize(
    ("keys", "arguments"),
    [
        ("reading: free", ["--reading", "free"]),
        ("vehicle: crazyflie_brushless", ["--vehicle", "crazyflie_brushless"]),
    ],
)
def test_a_file_that_says_what_flies_it_is_planned_for_that(
    keys: str, arguments: list[str], tmp_path: Path
) -> None:
    """As with the option, and the option comes first; the file without either is planned otherwise."""
    path, out, plans = tmp_path / "untimed.yaml", tmp_path / "plan.json", []
    fast = ["--speed", "9", "--acceleration", "9"]
    for text, options in ((keys, []), ("", arguments), ("reading: stop_and_go", arguments), ("", [])):
        path.write_text(f"{text}\n{UNTIMED}")
        assert main([str(path), "--out", str(out), *fast, *options]) == 0
        plans.append(out.read_text())
    assert plans[0] == plans[1] == plans[2] != plans[3]


def test_the_firmware_of_a_file_is_that_of_its_thrust(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, out = tmp_path / "hasty.yaml", tmp_path / "plan.json"
    asked = [str(path), "--out", str(out)]
    path.write_text(HASTY)
    assert main(asked) == 1
    assert "crazyflie_2_0 has at most 0.439 N" in capsys.readouterr().err
    path.write_text(f"firmware: thrust_upgrade\n{HASTY}")
    assert main(asked) == 0
    assert main([*asked, "--vehicle", "crazyflie_2_1"]) == 0
    path.write_text(f"firmware: none_such\n{HASTY}")
    assert main(asked) == 1
    assert (
        f"{path}: unknown firmware 'none_such' of crazyflie_2_0; choose one of stock"
        in capsys.readouterr().err
    )
