"""`plan` writes what it says, and says in one line what is wrong."""

import csv
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from numpy.polynomial import Polynomial
from section_4_1 import SECTION_4_1

from q2q_model.downwash.jet import PAPER_LAW
from q2q_model.signals.values import Array
from q2q_model.trajectory.plan_file import load, load_with_facts
from q2q_model.trajectory.polynomials import SwarmPlan
from q2q_model.vehicle.altitude_loop import PAPER_LOOP
from q2q_planner.commands.plan import main
from q2q_planner.offline.certificate import certificate
from q2q_planner.offline.certificate.certified_file import load_plan
from q2q_planner.offline.minimum_snap.flight_limits import FlightLimits
from q2q_planner.offline.minimum_snap.minimum_snap import minimum_snap_plan
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints, Waypoint
from q2q_planner.offline.zones.altitude_response import altitude_rms
from q2q_planner.offline.zones.downwash_zone import STEP
from q2q_planner.tools.export import write_samples
from q2q_planner.tools.waypoint_file import read_waypoints

WRITTEN = """
vehicles:
  cf1: [{t: 0, pos: [-1, 0, 0]}, {t: 20, pos: [0, 0, 2.5]}, {t: 50, pos: [1, 0, 0]}]
  cf2: [{t: 0, pos: [0, -1, 0]}, {t: 30, pos: [0, 0, 2.0]}, {t: 50, pos: [0, 1, 0]}]
"""


@pytest.fixture
def crossing(tmp_path: Path) -> Path:
    path = tmp_path / "crossing.yaml"
    path.write_text(WRITTEN)
    return path


def test_a_file_of_section_4_1_is_read_as_its_waypoints(crossing: Path) -> None:
    assert read_waypoints(crossing, FlightLimits(), "stop") == SECTION_4_1


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


def test_a_plan_too_large_for_the_proof_is_said_to_be_that(
    crossing: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(certificate, "MOST_STRETCHES", 1)
    assert main([str(crossing), "--no-avoid", "--out", str(tmp_path / "plan.json")]) == 0
    output = capsys.readouterr().out
    assert "NOT proven: 3 pieces of 2 vehicles are 3 stretches of pairs, more than 1 (" in output


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


def test_exports_hold_the_plan(crossing: Path, tmp_path: Path) -> None:
    out, table, uploads = tmp_path / "plan.json", tmp_path / "plan.csv", tmp_path / "uploads"
    arguments = [
        "--avoid",
        "--csv",
        str(table),
        "--upload",
        str(uploads),
    ]
    assert main([str(crossing), "--out", str(out), *arguments]) == 0
    plan = load(out)
    with table.open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 2 * 5001
    row = next(row for row in rows if row["t"] == "25.0" and row["name"] == "cf2")
    assert float(row["z"]) == pytest.approx(plan.trajectories[1].at(np.asarray(25.0))[2], abs=1e-12)
    with (uploads / "cf1.csv").open() as file:
        header, *pieces = list(csv.reader(file))
    assert header[:2] == ["Duration", "x^0"]
    assert len(header) == 33
    numbers = np.array(pieces, dtype=float)
    assert numbers[:, 0] == pytest.approx(plan.trajectories[0].durations, abs=0.0)
    assert numbers[:, 1:].reshape(-1, 4, 8) == pytest.approx(plan.trajectories[0].coefficients, abs=0.0)


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
    assert "cf1: 32 pieces; a Crazyflie's memory holds 31" in capsys.readouterr().err
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
    assert "cf1: 35 pieces; a Crazyflie's memory holds 31" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == [path]
    assert main([str(path), *arguments]) == 0


@pytest.mark.parametrize("option", ["--out", "--csv", "--json"])
def test_an_output_that_would_be_a_vehicle_s_upload_is_refused(
    option: str, crossing: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    uploads = tmp_path / "uploads"
    arguments = ["--out", str(tmp_path / "plan.json"), "--upload", str(uploads)]
    assert main([str(crossing), *arguments, option, str(uploads / "cf2.csv")]) == 1
    assert f"{uploads / 'cf2.csv'} is cf2's file of --upload" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == [crossing]


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
    assert "cut = 1.5: allowed is 0 to 1" in capsys.readouterr().err
    assert main([str(crossing), "--out", str(out), "--cut", "0.5"]) == 1
    assert "--cut 0.5 needs --model" in capsys.readouterr().err


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


def test_a_warm_start_reads_a_plan(crossing: Path, tmp_path: Path) -> None:
    cold, warm = tmp_path / "cold.json", tmp_path / "warm.json"
    assert main([str(crossing), "--out", str(cold)]) == 0
    assert main([str(crossing), "--warm-start", str(cold), "--out", str(warm)]) == 0
    assert load_plan(warm).certified


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
    assert f"{path}: firmware 'none_such' of crazyflie_2_0: known are stock" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("text", "arguments", "message"),
    [
        (WRITTEN.replace("20,", ".nan,"), [], "cf1, waypoint 1: t = nan"),
        (WRITTEN.replace("t: 20", "t: 0"), [], "cf1, waypoint 1: t = 0.0 s coincides"),
        (WRITTEN.replace("t: 20", "t: 60"), [], "cf1, waypoint 2: t = 50.0 s is before"),
        (WRITTEN.replace("t: 50", "t: 20.3"), [], "cf2, waypoint 2: t = 20.3 s is before"),
        (WRITTEN.replace("t: 20", "t: 0.5"), [], "cf1, after waypoint 0"),
        (
            WRITTEN.replace("t: 20", "t: 30"),
            [],
            "cf1, waypoint 1 and cf2, waypoint 1 lie 0.1 m inside",
        ),
        (WRITTEN, ["--eps", "-1"], "--eps = -1.0: allowed is 0 to 5.0 m"),
        (WRITTEN, ["--model", "paper_law", "--threshold", "99"], "threshold = 99"),
        (WRITTEN, ["--model", "measured_law", "--eps", "0.3"], "--eps and --model both choose the zone"),
        (
            WRITTEN,
            ["--model", "measured_law", "--threshold", "1", "--shape", "ellipsoid"],
            "--shape and --model both choose the zone",
        ),
        (WRITTEN, ["--model", "none"], "--model none has no downwash, so no zone: name another, or give"),
        (
            WRITTEN,
            ["--no-avoid", "--model", "paper_law", "--cut", "0.9"],
            "--cut 0.9 needs --model, and neither --threshold, which it chooses, nor --no-avoid",
        ),
        ("vehicles: [", [], "bad.yaml: is not valid YAML: line 1: expected the node content"),
        (WRITTEN, ["--threshold", "1"], "needs --model"),
        ("nothing: 1", [], "the file: vehicles is missing"),
    ],
)
def test_what_cannot_be_planned_is_said_in_one_line(
    text: str, arguments: list[str], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, out = tmp_path / "bad.yaml", tmp_path / "plan.json"
    path.write_text(text)
    assert main([str(path), "--out", str(out), *arguments]) == 1
    error = capsys.readouterr().err
    assert message in error
    assert error.startswith("plan: ")
    assert "Traceback" not in error
    assert not out.exists()


def refusal(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> str:
    """Return the message of a command line that contradicts itself, which ends with status 2."""
    with pytest.raises(SystemExit) as ended:
        main(arguments)
    assert ended.value.code == 2
    return capsys.readouterr().err


def test_a_warm_start_without_a_search_is_refused(
    crossing: Path, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    out = tmp_path / "plan.json"
    words = refusal([str(crossing), "--no-avoid", "--warm-start", str(crossing), "--out", str(out)], capsys)
    assert (
        "--warm-start starts the search for a way around, which --no-avoid omits: give one of them" in words
    )
    assert not out.exists()


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--out", "crossing.yaml"], "the waypoint file and --out are both "),
        (["--out", "plan.json", "--json", "plan.json"], "--out and --json are both "),
        (["--out", "plan.json", "--csv", "new/../crossing.yaml"], "the waypoint file and --csv are both "),
        (["--out", "old.json", "--warm-start", "old.json"], "--warm-start and --out are both "),
        (["--out", "plan.json", "--upload", "old.json"], "old.json is a file; give a folder"),
        (["--out", "plan.json", "--figures", "old.json"], "old.json is a file; give a folder"),
        (["--out", "plan.json", "--csv", "old.json/a.csv"], "old.json is a file; it cannot hold a.csv"),
        (["--out", "plan.json", "--csv", "ups", "--upload", "ups"], "ups, which --upload needs as a folder"),
        (["--out", "plan.json", "--csv", "a", "--figures", "a/b"], "a, which --figures needs as a folder"),
        (["--out", "plan.json", "--csv", "plan.json/a.csv"], "plan.json, which --csv needs as a folder"),
    ],
)
def test_no_file_is_written_twice_or_over_another(
    options: list[str],
    words: str,
    crossing: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(crossing.parent)
    Path("old.json").write_text("{}")
    Path("new").mkdir()
    assert words in refusal(["crossing.yaml", *options], capsys)
    assert crossing.read_text() == WRITTEN
    assert not Path("plan.json").exists()


def test_folders_of_the_table_are_made(crossing: Path, tmp_path: Path) -> None:
    table = tmp_path / "new" / "folder" / "plan.csv"
    assert main([str(crossing), "--no-avoid", "--out", str(tmp_path / "p.json"), "--csv", str(table)]) == 0
    assert table.read_text().startswith("t,name,x,y,z")


def test_an_absent_file_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([str(tmp_path / "none.yaml"), "--out", str(tmp_path / "p.json")]) == 1
    assert "none.yaml" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("option", "words"),
    [
        (["--initial-guesses", "0"], "--initial-guesses = 0: allowed is 1 to 100"),
        (["--speed", "0"], "--speed = 0.0: allowed is 0.01 to 50.0 m/s"),
        (["--acceleration", "nan"], "--acceleration = nan: allowed is 0.01 to 100.0 m/s^2"),
        (["--tilt", "20"], "--tilt = 20.0: allowed is 0.01 to 1.5 rad"),
    ],
)
def test_a_number_out_of_bounds_names_its_option(
    option: list[str], words: str, crossing: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([str(crossing), "--out", str(tmp_path / "plan.json"), *option]) == 1
    assert capsys.readouterr().err == f"plan: {words}\n"


def test_a_zone_that_cannot_be_drawn_is_refused_before_anything_is_written(
    crossing: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, figures = tmp_path / "plan.json", tmp_path / "figures"
    assert main([str(crossing), "--out", str(out), "--eps", "1e-4", "--figures", str(figures)]) == 1
    assert "the safe replanner, whose zone has eps = 0.0001: allowed is 0.001 to" in capsys.readouterr().err
    assert not out.exists()
    assert not figures.exists()
