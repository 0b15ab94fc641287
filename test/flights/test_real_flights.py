"""Identify real flights as a user does: table, bag, record, gains, model; skipped where there are none."""

import json
import os
from pathlib import Path

import pytest
from threadpoolctl import threadpool_limits

from q2q_model.commands import identify as identify_command
from q2q_model.identification.gains.command_gains import gains_from_commands
from q2q_model.identification.identification import ProcedureParams, identify
from q2q_model.identification.recorded_altitudes import recorded_altitudes
from q2q_model.recordings.flight_recording import Recording
from q2q_model.recordings.recordings_of_bags import recordings_of_bags
from q2q_model.vehicle.constants import CRAZYFLIE_2_0
from q2q_sim.commands import bag_import

DATA = Path(os.environ.get("Q2Q_DATA", Path(__file__).parents[3] / "shared" / "data")) / "neural_swarm"
FLIGHTS = sorted(path.stem for path in DATA.glob("*_ss*.parquet"))
"""Flights of two vehicles or more."""
KNOWN_GAINS = ("dc21_swap_ss_00", "dc21_swap_ss_02", "dc21_swap_ss_04", "dc21_swap_sss_02")
needs_flights = pytest.mark.skipif(not FLIGHTS, reason=f"real flights are not at {DATA}: set Q2Q_DATA")


@pytest.fixture(scope="module")
def bags(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Return the bag of every flight."""
    folder = tmp_path_factory.mktemp("bags")
    for name in FLIGHTS:
        assert bag_import.main([str(DATA / f"{name}.parquet"), "--out", str(folder / name)]) == 0
    return {name: folder / name for name in FLIGHTS}


@pytest.fixture(scope="module")
def recordings(bags: dict[str, Path]) -> dict[str, Recording]:
    """Return every flight, read."""
    found, _ = recordings_of_bags(list(bags.values()))
    return {one.flight.name: one for one in found}


@needs_flights
def test_gains_from_thrust_commands_are_those_that_flew(recordings: dict[str, Recording]) -> None:
    """The controller of these flights had K_p,z = 10 and K_d,z = 5 by its authors' word (Neural-Swarm2)."""
    flown = [recorded_altitudes(recordings[name], CRAZYFLIE_2_0) for name in KNOWN_GAINS]
    found = gains_from_commands([record for records, _ in flown for record in records])
    assert found.k_p.value == pytest.approx(10.0, rel=0.1)  # issue 3 asks for 10 %
    assert found.k_d.value == pytest.approx(5.0, rel=0.1)
    assert found.needs_offset  # each flight's constant, which a PD law without offset takes for downwash


@needs_flights
@pytest.mark.parametrize("kind", ["dc21_randomwalk_ss_", "dc21_randomwalk_sss_", "dc21_"])
def test_gains_of_random_walks_are_those_of_swaps(kind: str, recordings: dict[str, Recording]) -> None:
    """A walk's velocity setpoint is at its limit in a third of its rows: with them, K_p is 8.3, K_d 3.8."""
    flown = [recorded_altitudes(recordings[name], CRAZYFLIE_2_0) for name in FLIGHTS if name.startswith(kind)]
    found = gains_from_commands([record for records, _ in flown for record in records])
    assert found.k_p.value == pytest.approx(
        10.0, rel=0.02
    )  # of swaps 10.13: the tilt of |f| is not that of the vehicle
    assert found.k_d.value == pytest.approx(5.0, rel=0.02)


@needs_flights
@pytest.mark.parametrize("name", FLIGHTS)
def test_every_real_flight_goes_through_identify(name: str, bags: dict[str, Path], tmp_path: Path) -> None:
    out = tmp_path / "model.q2q"
    assert identify_command.main([str(bags[name]), "--out", str(out), "--no-plots"]) == 0
    report = json.loads(out.with_suffix(".json").read_text())
    assert report["model"]["type"] == "jet"
    assert report["gains"]["source"] == "commands"
    assert all(one["type"] == "jet" for one in report["candidates"])  # encounters are long: no networks
    assert any("the paper's two networks: not tried" in remark for remark in report["remarks"])


@needs_flights
def test_pairs_of_real_flights_go_through_identify(recordings: dict[str, Recording]) -> None:
    """In process; every flight is in a pair."""
    half = (len(FLIGHTS) + 1) // 2
    with threadpool_limits(1, user_api="blas"):
        for pair in zip(FLIGHTS[:half], FLIGHTS[-half:], strict=True):
            found = identify([recordings[name] for name in pair], ProcedureParams(), lambda _: None)
            assert found.chosen.kind == "jet", pair
