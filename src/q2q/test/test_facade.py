"""The public names: scenarios, plans, models and campaigns as the packages below have them."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import q2q
from q2q_model.model_files.model_file import encode
from q2q_model.trajectory.polynomials import setpoint_at
from q2q_planner.offline.certificate.certificate import certify
from q2q_sim.campaigns.random_runs.campaign_flight import fly_and_judge

CROSSING = {
    "vehicles": {
        "cf1": [{"t": 0.0, "pos": [-1.0, 0.0, 1.0]}, {"t": 4.0, "pos": [1.0, 0.0, 1.0]}],
        "cf2": [{"t": 0.0, "pos": [0.0, -1.0, 1.4]}, {"t": 4.0, "pos": [0.0, 1.0, 1.4]}],
    }
}


def test_every_public_name_is_documented():
    lacking = [name for name in q2q.__all__ if not getattr(q2q, name).__doc__]
    assert lacking == []
    assert q2q.__all__ == sorted(q2q.__all__)


def test_a_scenario_is_found_by_name_and_changed_like_any_dataclass():
    found = q2q.scenario("table6", vehicle="crazyflie_2_1", wake="measured")
    assert (found.vehicle.name, found.wake) == ("crazyflie_2_1", "measured")
    assert replace(found, duration=3.0).duration == 3.0
    assert q2q.scenario(found) == found
    assert "table6" in q2q.scenario_names()


def test_a_wake_and_an_air_in_its_place_are_refused_together():
    with pytest.raises(ValueError, match=r"^wake = 'paper' and air = 'room': give one of them"):
        q2q.scenario("table6", wake="paper", air="room")


def test_an_unknown_scenario_is_refused_with_the_nearest_name():
    with pytest.raises(ValueError, match="table6"):
        q2q.scenario("tabel6")


def test_a_document_is_a_scenario_that_ends_at_its_last_waypoint():
    assert q2q.scenario(CROSSING).duration == 4.0
    assert q2q.scenario(CROSSING).names == ("cf1", "cf2")


def test_numbers_of_numpy_in_a_document_are_numbers():
    given = {
        "vehicles": {
            "cf1": [{"t": np.int64(0), "pos": np.array([-1, 0, 1])}, {"t": 4, "pos": [1, 0, np.int64(1)]}],
            "cf2": CROSSING["vehicles"]["cf2"],
        },
        "duration": np.float32(4.0),
        "radio": {"latency": np.float64(0.25)},
        "overrides": {"pid": {"k_p_z": np.int64(3)}},
        "faults": [{"kind": "dropout", "start": np.int64(1)}],
    }
    found = q2q.scenario(given)
    assert found.waypoints == q2q.scenario(CROSSING).waypoints
    assert (found.duration, found.radio.latency, found.faults[0].start) == (4.0, 0.25, 1.0)
    assert found.overrides["pid"] == {"k_p_z": 3.0}
    assert [type(one) for one in (found.duration, found.overrides["pid"]["k_p_z"])] == [float, float]
    assert replace(found, overrides={"pid": {"k_p_z": np.float32(0.5)}}).overrides
    with pytest.raises(ValueError, match="no parameter 'on'"):
        q2q.scenario({**given, "overrides": {"pid": {"on": np.True_}}})


def test_a_plan_passes_its_waypoints_and_around_a_model_stays_out_of_its_zone():
    free, around = q2q.plan(CROSSING), q2q.plan(CROSSING, around="none")
    np.testing.assert_allclose(setpoint_at(free, 4.0).pos, [[1.0, 0.0, 1.0], [0.0, 1.0, 1.4]], atol=1e-9)
    zone = q2q.load_model("none").zone
    assert not certify(free, zone).holds
    assert certify(around, zone).holds


def test_a_model_is_saved_and_loaded_unchanged(tmp_path: Path):
    known = q2q.load_model("measured_law")
    saved = q2q.load_model(q2q.save_model(known, tmp_path / "m.q2q"))
    assert encode(saved) == encode(known)
    assert q2q.load_model(known.interaction).interaction == known.interaction


def test_a_campaign_yields_the_outcome_of_each_seed(tmp_path: Path):
    (outcome,) = q2q.campaign(1, seed=7, out=tmp_path)
    expected = fly_and_judge(7, tmp_path)
    assert (outcome.seed, outcome.what, outcome.violations) == (7, expected.what, expected.violations)


@pytest.mark.parametrize(("bags", "answer"), [("absent", "no bag at absent"), ([], "no bags: give")])
def test_a_single_path_is_one_bag_and_no_bag_is_refused(bags: str | list[str], answer: str):
    with pytest.raises(ValueError, match=answer):
        q2q.identify(bags)


def test_a_model_is_identified_from_bags():
    bags = Path(__file__).parents[3] / "bags"
    found = q2q.identify([bags / "table2_1", bags / "table2_5"], model_type="jet")
    # gains of the simulated loop, section 2.2
    assert found.gains.loop.k_p == pytest.approx(0.81073, rel=0.02)
    assert found.held_out.r2.lower > 0.95
    assert q2q.load_model(found) is found.file


def test_an_outcome_names_the_air_of_its_campaign(tmp_path: Path):
    (outcome,) = q2q.campaign(1, seed=7, air="bent", out=tmp_path)
    assert outcome.air == "bent"


@pytest.mark.parametrize(
    ("runs", "choice"), [(0, {}), (-1, {}), (1, {"jobs": 0}), (1, {"jobs": -1}), (1, {"seed": -5})]
)
def test_a_campaign_of_no_runs_is_refused_at_once(runs: int, choice: dict[str, int]):
    with pytest.raises(ValueError, match="must be an integer >= "):
        q2q.campaign(runs, **choice)


@pytest.mark.parametrize("around", [None, "measured_law"])
def test_a_plan_that_a_vehicle_cannot_fly_is_refused(around: str | None):
    ends = {"cf1": (-1.0, 0.0), "cf2": (1.0, 0.6)}
    hasty = {
        "vehicles": {
            name: [{"t": 0.0, "pos": [x, y, 1.0]}, {"t": 1.6, "pos": [-x, y, 1.0]}]
            for name, (x, y) in ends.items()
        }
    }
    with pytest.raises(ValueError, match=r"cf1, after waypoint 0 .* tilts by 0\.5\d+ rad, but controllers"):
        q2q.plan(hasty, around=around)


def test_the_terms_of_a_learned_air_are_replaced_through_its_exported_type() -> None:
    air = q2q.load_air("room", without=("residual",))
    assert isinstance(air, q2q.RoomAir)
    assert (replace(air, jet=None).jet, air.residual) == (None, None)
    assert not isinstance(q2q.load_air("measured"), q2q.RoomAir)
