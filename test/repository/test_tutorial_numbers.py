"""The height errors that a tutorial quotes are those of the scenario that it has its reader write."""

import re
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
import yaml
from documentation import blocks
from fresh_checkout import ROOT

from q2q_model.flights.flight import Flight
from q2q_model.identification.selection.jet_candidates import FORMS
from q2q_model.model_files.find_model import find_model
from q2q_model.trajectory.polynomials import setpoint_at
from q2q_sim.air.lookup.find_air import find_air
from q2q_sim.loop.closed_loop import FlightOptions, fly
from q2q_sim.loop.flight_blocks import Mode, plan_of
from q2q_sim.monitors.metrics.flight_metrics import VehicleMetrics, measure
from q2q_sim.scenarios import library

CRAZYSWARM = ROOT / "docs/tutorials/real_vehicles_with_crazyswarm2.md"
COLUMN = ROOT / "docs/tutorials/add_an_interaction_model.md"
IDENTIFY = ROOT / "docs/tutorials/identify_your_bag.md"
REAL_FLIGHTS = ROOT / "docs/real_flights.md"
TUTORIAL = ROOT / "docs/tutorials/fly_your_scenario.md"
WORDS = " ".join(TUTORIAL.read_text(encoding="utf-8").split())
QUOTED = re.compile(
    r"`cf2` has a height error of (\d+) mm rms and sinks by (\d+) cm.*?Aware of it, the error is (\d+) mm",
    re.DOTALL,
)


OTHERS: tuple[tuple[str, Mode, str, str], ...] = (
    (r"never under `cf1` \(error (\d+) mm\)", "ignoring", "pid", "safe"),
    (r"in the zone, with an error of (\d+) mm", "ignoring", "pid", "paper"),
    (r"constant offsets: the error is (\d+) mm", "aware", "mpc", "none"),
)
"""Quoted error, mode, controller and replanner of further flights."""


def flown(path: Path, mode: Mode, controller: str = "pid", replan: str = "none") -> VehicleMetrics:
    """Return the metrics of cf2."""
    return measure(recorded(path, mode, controller, replan), library.load(str(path)).vehicle).vehicles["cf2"]


def recorded(path: Path, mode: Mode, controller: str = "pid", replan: str = "none") -> Flight:
    """Return the flight of a scenario's file."""
    scenario = library.load(str(path))
    model, air = find_model(scenario.model).interaction, find_air(scenario.air)
    return fly(scenario, FlightOptions(mode, controller, replan, model=model, air=air))


def test_the_errors_of_the_tutorials_first_two_flights_are_those_quoted(tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text(next(one.text for one in blocks(TUTORIAL) if one.action == "write"))
    found = QUOTED.search(TUTORIAL.read_text(encoding="utf-8"))
    assert found is not None
    rms_mm, sunk_cm, aware_mm = map(float, found.groups())
    ignoring = flown(path, "ignoring")
    assert 1000.0 * ignoring.z_rmse_m == pytest.approx(rms_mm, abs=0.5)  # quoted to the last digit
    assert 100.0 * ignoring.worst_m == pytest.approx(sunk_cm, abs=0.5)
    assert 1000.0 * flown(path, "aware").z_rmse_m == pytest.approx(aware_mm, abs=0.5)


@pytest.mark.parametrize(("quoted", "mode", "controller", "replan"), OTHERS)
def test_the_errors_of_its_replanners_and_mpc_are_those_quoted(
    quoted: str, mode: Mode, controller: str, replan: str, tmp_path: Path
) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text(next(one.text for one in blocks(TUTORIAL) if one.action == "write"))
    found = re.search(quoted, TUTORIAL.read_text(encoding="utf-8"))
    assert found is not None
    error = flown(path, mode, controller, replan).z_rmse_m
    assert 1000.0 * error == pytest.approx(float(found[1]), abs=0.5)


def test_the_mpc_raises_its_thrust_as_long_before_the_downwash_as_quoted_and_does_not_climb(
    tmp_path: Path,
) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text(next(one.text for one in blocks(TUTORIAL) if one.action == "write"))
    quoted = re.search(r"thrust ([\d.]+) s before `cf2` enters.*?(\d) mm lower", WORDS)
    assert quoted is not None
    aware, ignoring = (recorded(path, mode, "mpc") for mode in ("aware", "ignoring"))
    enters = int(np.flatnonzero(aware.eta[:, 1, 2] < -0.1)[0])  # the threshold of the zone [m/s^2]
    raises = int(np.flatnonzero(aware.thrust[:, 1] > ignoring.thrust[:, 1] + 0.002)[0])  # 0.6 % of the weight
    assert aware.t[enters] - aware.t[raises] == pytest.approx(float(quoted[1]), abs=0.05)
    higher = (aware.true_pos - ignoring.true_pos)[:enters, 1, 2]
    assert higher.max() < 1e-4  # both fly alike until the prediction shows the downwash
    assert -1000.0 * higher.min() == pytest.approx(float(quoted[2]), abs=0.5)


def test_the_papers_gains_fly_this_scenario_as_quoted(tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    text = next(one.text for one in blocks(TUTORIAL) if one.action == "write")
    path.write_text(re.sub(r"^  pid: .*\n", "", text, flags=re.MULTILINE))
    words = r"`cf1`, in clear air, is ([\d.]+) m off \(rms\), and `cf2` ([\d.]+) m: .* floor at ([\d.]+) s"
    quoted = re.search(words, WORDS)
    assert quoted is not None
    flight = recorded(path, "ignoring")
    errors = measure(flight, library.load(str(path)).vehicle).vehicles
    for name, error in zip(("cf1", "cf2"), quoted.groups(), strict=False):
        assert errors[name].z_rmse_m == pytest.approx(float(error), abs=0.005)  # quoted to the last digit
    lowest = int(np.argmin(flight.true_pos[:, 1, 2]))
    assert flight.true_pos[lowest, 1, 2] < 0.01
    assert flight.t[lowest] == pytest.approx(float(quoted[3]), abs=0.05)


def test_the_error_with_its_faults_is_that_quoted(tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    parts = [one.text for one in blocks(TUTORIAL) if one.file == "out/mine.yaml"]
    assert len(parts) == 3
    path.write_text("".join(parts))
    found = re.search(r"with both changes \(the error is (\d+) mm\)", TUTORIAL.read_text(encoding="utf-8"))
    assert found is not None
    assert 1000.0 * flown(path, "aware").z_rmse_m == pytest.approx(float(found[1]), abs=0.5)


def test_the_pair_of_the_crazyswarm_tutorial_has_the_errors_quoted_above_its_initial_positions(
    tmp_path: Path,
) -> None:
    written = {one.file: one.text for one in blocks(CRAZYSWARM) if one.action == "write"}
    path = tmp_path / "pair.yaml"
    path.write_text(written["out/pair.yaml"])
    found = re.search(r"error of (\d+) mm rms, then (\d+) mm", CRAZYSWARM.read_text(encoding="utf-8"))
    assert found is not None
    assert 1000.0 * flown(path, "ignoring").z_rmse_m == pytest.approx(float(found[1]), abs=0.5)
    assert 1000.0 * flown(path, "aware").z_rmse_m == pytest.approx(float(found[2]), abs=0.5)
    robots = yaml.safe_load(written["crazyflies.yaml"])["robots"]
    first = setpoint_at(plan_of(library.load(str(path))), 0.0)
    on_ground = [robots[name]["initial_position"][:2] for name in first.names]
    np.testing.assert_allclose(first.pos[:, :2], on_ground, atol=1e-9)


def test_the_column_of_the_interaction_tutorial_helps_by_what_is_quoted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (law,) = (one for one in blocks(COLUMN) if one.file.endswith("downwash/column.py"))
    (tmp_path / "tutorial_column.py").write_text(law.text)
    monkeypatch.syspath_prepend(tmp_path)
    column = import_module("tutorial_column").Column
    words = r"is ([\d.]+) mm ignoring .* and ([\d.]+) mm with the\s+column.*=2.0\)` the error is ([\d.]+) mm"
    found = re.search(words, COLUMN.read_text(encoding="utf-8"), re.DOTALL)
    assert found is not None
    scenario = library.load("table2_3")
    aware = [FlightOptions(model=one) for one in (column(), column(strength=2.0))]
    for options, quoted in zip((FlightOptions("ignoring"), *aware), found.groups(), strict=True):
        error = measure(fly(scenario, options), scenario.vehicle).vehicles["cf1"].z_rmse_m
        assert 1000.0 * error == pytest.approx(float(quoted), abs=0.05)  # quoted to the last digit


def test_the_scores_quoted_for_real_flights_are_the_extremes_of_their_table() -> None:
    rows = re.findall(
        r"^\| `dc\d\d_\w+` \| \d+ \| ([\d.]+) \|", REAL_FLIGHTS.read_text(encoding="utf-8"), re.MULTILINE
    )
    assert len(rows) == 16
    quoted = re.search(r"R2 of (\d\.\d+) to (\d\.\d+)", IDENTIFY.read_text(encoding="utf-8"))
    assert quoted is not None
    assert quoted.groups() == (min(rows), max(rows))


def test_the_forms_quoted_are_those_that_are_fitted() -> None:
    text = IDENTIFY.read_text(encoding="utf-8")
    assert "fits five forms of the jet (four if no flight has measured downwash)" in text
    assert (len(FORMS), sum(not form.loaded for form in FORMS.values())) == (5, 4)
