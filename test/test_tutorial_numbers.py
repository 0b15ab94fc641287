"""The height errors that a tutorial quotes are those of the scenario that it has its reader write."""

import re
from pathlib import Path

import pytest
from documentation import blocks
from fresh_checkout import ROOT

from q2q_model.files.find_model import find_model
from q2q_model.vehicle.constants import CRAZYFLIE_2_0
from q2q_sim.air.find_air import find_air
from q2q_sim.loop.assembly import Mode
from q2q_sim.loop.closed_loop import FlightOptions, fly
from q2q_sim.monitors.metrics import VehicleMetrics, measure
from q2q_sim.scenarios import library

TUTORIAL = ROOT / "docs/tutorials/fly_your_scenario.md"
QUOTED = re.compile(
    r"`cf2` has a height error of (\d+) mm rms and sinks by (\d+) cm.*?Aware of it, the error is (\d+) mm",
    re.DOTALL,
)


def flown(path: Path, mode: Mode) -> VehicleMetrics:
    """Return the metrics of cf2."""
    scenario = library.load(str(path))
    options = FlightOptions(mode, model=find_model(scenario.model).interaction, air=find_air(scenario.air))
    return measure(fly(scenario, options), CRAZYFLIE_2_0).vehicles["cf2"]


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
