"""Run identify and evaluate as a user does, on the bags of the repository."""

import json
import re
import shutil
from dataclasses import replace
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from q2q_model.bag import BagError
from q2q_model.commands import evaluate, identify
from q2q_model.identification.push.along_flight import eta_along
from q2q_model.identification.push.recorded_push import motion_of
from q2q_model.model_files.model_file import load, save
from q2q_model.recordings.recordings_of_bags import bags_among, recordings_of_bags
from q2q_model.vehicle.constants import CRAZYFLIE_2_0

BAGS = Path(__file__).resolve().parents[4] / "bags"
NUMBERS = ("r2_exposed", "rmse_exposed_mps2", "mean_upper_mps2", "r2_ahead_20ms")
FLIGHTS = [BAGS / f"table2_{k}" for k in (1, 2, 5)]
needs_bags = pytest.mark.skipif(not FLIGHTS[0].is_dir(), reason=f"no recorded flights in {BAGS}")


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of one identification of three flights."""
    folder = tmp_path_factory.mktemp("identified")
    words = [*map(str, FLIGHTS), "--out", str(folder / "model.q2q"), "--model-type", "jet"]
    assert identify.main([*words, "--json", str(folder / "report.json")]) == 0
    return folder


@needs_bags
def test_the_report_holds_what_its_contract_names(found: Path):
    report = json.loads((found / "report.json").read_text())
    assert report["gains"]["k_p"] == pytest.approx([0.81073] * 3, rel=1e-4)  # what the simulator's PID flies
    assert report["gains"]["k_d"] == pytest.approx([0.42952] * 3, rel=1e-4)
    for name in ("k_p", "k_d"):
        value, low, high = report["gains"][name]
        assert low <= value <= high
    assert report["outliers"]["samples"] > 10_000
    assert report["outliers"]["found"] > 0
    assert {"eps_m", "d_m", "alpha_m", "beta_per_m", "extrapolated"} <= set(report["zone"])
    model = report["model"]
    assert model["type"] == "jet"
    assert model["parameters"] <= 200
    assert model["heldout_r2"]["lower"] > 0.9
    assert model["r2_of"] == "downwash"
    assert model["heldout_mse_m2"]["lower"] < 1.13e-3  # the paper's training errors, section 3.2
    assert model["heldout_mse_m2"]["upper"] < 1.87e-3
    assert {"strength", "width", "upper_ratio"} <= set(model["intervals"])
    assert all(low <= value <= high for value, low, high in model["intervals"].values())
    assert report["loading"] == {"interval": None, "used": 0.0}  # two vehicles cannot show it
    assert report["seconds"]["total"] > 0.0


@needs_bags
def test_the_learned_downwash_is_that_of_the_simulators_air(found: Path):
    law = load(found / "model.q2q").interaction
    missed = total = 0.0
    for bag in FLIGHTS:
        flight = recordings_of_bags([bag])[0][0].flight
        true, learned = flight.true_eta[..., 2], eta_along(law, motion_of(flight))[..., 2]
        visited = np.abs(true).max(axis=1) > 1e-3
        missed += float(((learned - true)[visited] ** 2).sum())
        total += float((true[visited] ** 2).sum())
    assert (missed / total) ** 0.5 < 0.10


@needs_bags
def test_every_figure_is_drawn(found: Path):
    pictures = sorted(path.name for path in found.glob("*.png"))
    figures = ("fig4_dev", "fig5_gains", "fig6_7_altitude", "fig8_9_downwash")
    assert pictures == [f"report_{name}.png" for name in figures]
    assert all((found / name).stat().st_size > 10_000 for name in pictures)


@needs_bags
def test_evaluate_scores_the_model_by_flight_and_pooled(found: Path, capsys: pytest.CaptureFixture[str]):
    out = found / "scores.json"
    words = ["--model", str(found / "model.q2q"), str(FLIGHTS[0]), "--json", str(out)]
    assert evaluate.main(words) == 0
    scores = json.loads(out.read_text())
    assert set(scores) == {"thrust_lag_s", "flights", "pooled"}
    assert scores["thrust_lag_s"] == CRAZYFLIE_2_0.thrust_lag
    assert set(scores["pooled"]) == {*NUMBERS, "n"}
    assert scores["flights"]["table2_1"] == scores["pooled"] | {"in_fit": True}
    assert scores["pooled"]["r2_exposed"] > 0.9
    output = capsys.readouterr()
    assert re.search(
        r"table2_1 .*, this flight is in the fit: not held out$",
        output.out,
        re.MULTILINE,
    )
    pooled = rf"^pooled +R2 +0\.\d+, 20 ms ahead 0\.\d+, rmse 0\.\d+ m/s\^2, {scores['pooled']['n']} rows"
    assert re.search(pooled, output.out, re.MULTILINE)
    assert "push of 1 flight is from imu and command, with a thrust lag of 0.07 s" in output.err


@needs_bags
def test_evaluate_knows_a_fitted_flight_by_its_contents_or_its_name(
    found: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    shutil.copytree(FLIGHTS[0], tmp_path / "renamed")
    assert evaluate.main(["--model", str(found / "model.q2q"), str(tmp_path / "renamed")]) == 0
    assert re.search(
        r"^renamed .*, this flight is in the fit: not held out$", capsys.readouterr().out, re.MULTILINE
    )
    model = load(found / "model.q2q")
    assert model.fit is not None
    save(tmp_path / "old.q2q", replace(model, fit=replace(model.fit, digests=())))
    assert evaluate.main(["--model", str(tmp_path / "old.q2q"), str(FLIGHTS[0])]) == 0
    assert (
        "a flight of this name is in the fit: if it is this one, it is not held out"
        in capsys.readouterr().out
    )


@needs_bags
def test_evaluate_takes_the_thrust_lag_of_the_vehicle_that_flew(found: Path, tmp_path: Path):
    model = load(found / "model.q2q")
    assert model.gains is not None
    other = replace(model, gains=replace(model.gains, lag=0.12))
    save(tmp_path / "other.q2q", other)
    out = tmp_path / "scores.json"
    words = ["--model", str(tmp_path / "other.q2q"), str(FLIGHTS[0]), "--json", str(out)]
    assert evaluate.main(words) == 0
    assert json.loads(out.read_text())["thrust_lag_s"] == CRAZYFLIE_2_0.thrust_lag


@needs_bags
def test_flights_keep_names_of_their_own_however_their_folders_are_called(tmp_path: Path):
    places = ("gap_0.2", "gap_0.4", "monday/room/swap", "tuesday/room/swap")
    for number, place in enumerate(places, 1):
        shutil.copytree(BAGS / f"table2_{number}", tmp_path / place)
    recordings, _ = recordings_of_bags([tmp_path / place for place in places])
    assert [one.flight.name for one in recordings] == list(places)
    out = tmp_path / "scores.json"
    words = ["--model", "paper_law", *(str(tmp_path / place) for place in places), "--json", str(out)]
    assert evaluate.main(words) == 0
    scores = json.loads(out.read_text())
    assert list(scores["flights"]) == list(places)
    assert scores["pooled"]["n"] == sum(one["n"] for one in scores["flights"].values())


@needs_bags
def test_a_flight_that_is_given_again_as_a_copy_or_by_its_file_is_refused(tmp_path: Path):
    shutil.copytree(FLIGHTS[0], tmp_path / "copy")
    for again in (tmp_path / "copy", next(FLIGHTS[0].glob("*.mcap"))):
        with pytest.raises(BagError, match=f"{FLIGHTS[0].name} and .*{again.name} contain the same flight"):
            recordings_of_bags([FLIGHTS[0], FLIGHTS[1], again])


@needs_bags
def test_what_lies_beside_bags_is_left_out_of_a_glob_with_a_note(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    beside = sorted(path for path in BAGS.glob("*") if path.name in ("remake", "table2_1"))
    assert [path.name for path in beside] == ["remake", "table2_1"]
    (tmp_path / "notes").mkdir()
    kept, notes = bags_among([*beside, tmp_path / "notes", tmp_path / "not there"])
    assert kept == [beside[1], tmp_path / "not there"]  # reading says that nothing is there
    assert notes == [f"skipped: {path} is not a bag" for path in (beside[0], tmp_path / "notes")]
    assert evaluate.main([*map(str, beside), "--model", "paper_law"]) == 0
    assert f"evaluate: skipped: {beside[0]} is not a bag" in capsys.readouterr().err
    assert evaluate.main([str(beside[0]), "--model", "paper_law"]) == 1
    assert "remake" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["no_such_bag", "--out", "m.q2q"], "no_such_bag"),
        (["--live", "--out", "m.q2q", "--model", "paper_low"], "no model 'paper_low': give one of"),
        (["--live", "--out", "m.q2q", "--model", "none"], "--model none has no downwash for --live to scale"),
    ],
)
def test_wrong_input_of_identify_is_one_line_without_a_traceback(
    words: list[str], says: str, capsys: pytest.CaptureFixture[str]
):
    assert identify.main(words) == 1
    lines = capsys.readouterr().err.strip().splitlines()
    assert len(lines) == 1
    assert says in lines[0]


@pytest.mark.parametrize("words", [["--out", "m.q2q"], ["bag", "--live", "--out", "m.q2q"], ["bag"]])
def test_identify_wants_bags_or_live_and_a_place_for_the_model(
    words: list[str], capsys: pytest.CaptureFixture[str]
):
    with pytest.raises(SystemExit) as end:
        identify.main(words)
    assert end.value.code == 2
    assert "see --help" in capsys.readouterr().err


INPUTS = ("bag.mcap", "m.q2q", "map.yaml")


@pytest.fixture
def inputs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the working folder, which holds a file of each kind of input."""
    monkeypatch.chdir(tmp_path)
    for name in INPUTS:
        Path(name).write_text(name)
    return tmp_path


@pytest.mark.parametrize(
    ("tool", "words", "says"),
    [
        (identify, ["--out", "x.json"], "--out and the report next to it are both x.json"),
        (identify, ["--out", "x.q2q", "--json", "./x.q2q"], "--out and --json are both x.q2q: give each a"),
        (identify, ["--out", "map.yaml", "--topics", "map.yaml"], "--topics and --out are both map.yaml"),
        (identify, ["--out", "bag.mcap"], "a bag and --out are both bag.mcap"),
        (identify, ["--out", "map.q2q", "--json", "bag.mcap"], "a bag and --json are both bag.mcap"),
        (evaluate, ["--model", "m.q2q", "--json", "m.q2q"], "--model and --json are both m.q2q"),
        (evaluate, ["--model", "none", "--json", "bag.mcap"], "a bag and --json are both bag.mcap"),
    ],
)
def test_no_result_is_written_over_another_or_over_what_is_read(
    tool: ModuleType,
    words: list[str],
    says: str,
    inputs: Path,
    capsys: pytest.CaptureFixture[str],
):
    with pytest.raises(SystemExit) as end:
        tool.main(["bag.mcap", *words])
    assert end.value.code == 2
    assert says in capsys.readouterr().err
    assert {path.name: path.read_text() for path in inputs.iterdir()} == {name: name for name in INPUTS}


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["bag.mcap", "--model", "m.q2q"], "--model needs --live, not bags of recorded flights"),
        (["--live", "--topics", "map.yaml"], "--topics needs bags of recorded flights, not --live"),
        (["--live", "--json=r.json"], "--json needs bags of recorded flights, not --live"),
        (["--live", "--threshold", "0.1"], "--threshold needs bags of recorded flights, not --live"),
        (["--live", "--model-type", "auto"], "--model-type needs bags of recorded flights, not --live"),
        (["bag.mcap", "--ros-args", "-p", "prior:=1.0", "--"], "--ros-args -p needs --live, not bags"),
        (["--live", "--no-plots"], "--no-plots needs bags of recorded flights, not --live"),
    ],
)
def test_identify_refuses_options_without_effect_even_at_their_defaults(
    words: list[str], says: str, inputs: Path, capsys: pytest.CaptureFixture[str]
):
    with pytest.raises(SystemExit) as end:
        identify.main([*words, "--out", str(inputs / "new.q2q")])
    assert end.value.code == 2
    assert says in capsys.readouterr().err
    assert not (inputs / "new.q2q").exists()


def test_evaluate_of_an_unknown_model_names_those_there_are(capsys: pytest.CaptureFixture[str]):
    assert evaluate.main(["bag", "--model", "paper_low"]) == 1
    assert "paper_law" in capsys.readouterr().err


def test_help_shows_an_example(capsys: pytest.CaptureFixture[str]):
    for tool in (identify, evaluate):
        with pytest.raises(SystemExit):
            tool.main(["--help"])
        assert "ros2 run q2q_model" in capsys.readouterr().out
