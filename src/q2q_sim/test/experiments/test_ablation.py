"""The ablation measures what it says: draws are flights of their own, air and model share no flight."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from ablation_numbers import DATA, PASSAGE, SHORT, STRONG, WEAK, shipped

from q2q_model.downwash.correction.residual_process import REAL_FLIGHTS
from q2q_model.downwash.jet import PAPER_LAW
from q2q_model.downwash.level_set import peak_downwash
from q2q_model.identification.push.along_flight import Motion
from q2q_model.identification.push.push_samples import PushSamples
from q2q_model.signals.values import Array
from q2q_model.trajectory.polynomials import Trajectory
from q2q_sim.air.air_names import FLIGHTS, ROOM, SYNTHETIC
from q2q_sim.air.air_terms import WindTerm
from q2q_sim.air.lookup.find_air import find_air
from q2q_sim.air.room_air import RoomAir
from q2q_sim.experiments.ablation import learned_models, variant_flight
from q2q_sim.experiments.ablation.ablation_cases import (
    JUDGED,
    LAW,
    PATHS,
    PLANTS,
    Case,
    scenarios_of,
    trajectory_between,
)
from q2q_sim.experiments.ablation.learned_models import LEAST, LearnedModel, models_of, parts_of
from q2q_sim.experiments.ablation.onboard_flight import Trace
from q2q_sim.experiments.ablation.side_by_side import SPACING, side_by_side, with_vehicles
from q2q_sim.experiments.ablation.two_level_interval import median_interval
from q2q_sim.experiments.ablation.variant_flight import (
    COLUMNS,
    VariantFlight,
    draw_columns,
    fly_variant,
)
from q2q_sim.loop.flight_blocks import plan_of
from q2q_sim.monitors.metrics.exposure import exposure
from q2q_sim.scenarios import library
from q2q_sim.scenarios.scenario import Scenario


def errors(
    monkeypatch: pytest.MonkeyPatch, variant: str, models: tuple[LearnedModel, ...], air: RoomAir
) -> Array:
    """Return the height errors (T, n) of a short flight of one draw with each model."""
    traces: list[Trace] = []

    def keep(trace: Trace, _: int) -> Array:
        traces.append(trace)
        return np.zeros((1, len(COLUMNS)))

    def short(name: str) -> tuple[Scenario, ...]:
        still = [replace(one, duration=SHORT, vicon=type(one.vicon)()) for one in scenarios_of(name)]
        return tuple(replace(one, radio=type(one.radio)()) for one in still)

    monkeypatch.setattr(variant_flight, "draw_columns", keep)
    monkeypatch.setattr(variant_flight, "scenarios_of", short)
    case = Case("crossing")
    fly_variant(VariantFlight(case, variant, models, air, draws=len(models)))
    return traces[0].error


def test_draws_in_one_room_have_their_own_gusts_and_none_feels_another(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    gusts = RoomAir(wind=WindTerm((0.0, 0.0, 0.0), 0.2, 0.15))
    two = errors(monkeypatch, "observer", (STRONG, STRONG), gusts)
    assert np.abs(two[-1, :2] - two[-1, 2:]).min() > 1e-7
    calm = errors(monkeypatch, "aware", (STRONG, STRONG), RoomAir())
    # places 10 m off the origin lose two digits of the last bits
    np.testing.assert_allclose(calm[:, :2], calm[:, 2:], atol=1e-12)


@pytest.mark.parametrize("variant", ["aware", "distributed"])
def test_every_draw_is_flown_with_its_own_model(monkeypatch: pytest.MonkeyPatch, variant: str) -> None:
    both = errors(monkeypatch, variant, (STRONG, WEAK), RoomAir())
    strong, weak = (errors(monkeypatch, variant, (one, one), RoomAir())[:, :2] for one in (STRONG, WEAK))
    assert np.abs(strong - weak).max() > 1e-6
    np.testing.assert_allclose(both[:, :2], strong, atol=1e-12)
    np.testing.assert_allclose(both[:, 2:], weak, atol=1e-12)


def test_a_draw_is_measured_as_its_definition_says() -> None:
    ticks = 1000
    pos = np.zeros((ticks, 2, 3))
    pos[:, 1] = [1.0, 0.0, 0.5]
    pos[400:500, 1, 0] = 0.0
    error = np.full((ticks, 2), 0.01)
    error[450, 0] = -0.2
    error[:300] = 9.0  # settling is not judged
    found = draw_columns(Trace(pos, error), 2)
    row = dict(zip(COLUMNS, found[0], strict=True))
    assert found.shape == (1, len(COLUMNS))
    assert row["worst"] == pytest.approx(0.2)
    assert row["under"] == pytest.approx(np.sqrt((199 * 0.01**2 + 0.2**2) / 200))
    assert row["clear"] == pytest.approx(0.01)


@pytest.mark.parametrize("unbounded", [np.inf, -np.inf, np.nan])
def test_a_draw_with_an_error_that_is_not_finite_makes_its_cell_unknown(unbounded: float) -> None:
    pos = np.zeros((1000, 4, 3))
    pos[:, 1::2] = [1.0, 0.0, 0.5]
    pos[400:500, 1::2, 0] = 0.0
    error = np.full((1000, 4), 0.01)
    error[450, 0] = unbounded  # under another, in the first draw
    diverged, other = draw_columns(Trace(pos, error), 2)
    assert not np.isfinite(diverged[[0, 2]]).any()
    assert diverged[1] == pytest.approx(0.01)
    np.testing.assert_allclose(other, 0.01, rtol=1e-12)
    assert np.isnan(median_interval(np.array([[diverged[0], other[0]]]))).all()


def test_the_interval_of_a_median_is_that_of_the_models_where_draws_agree() -> None:
    rng = np.random.default_rng(0)
    alone, alike = rng.normal(size=(6, 1)), rng.normal(size=(6, 1)) + 0.01 * rng.normal(size=(6, 20))
    assert median_interval(np.repeat(alone, 20, axis=1)) == median_interval(alone)  # 120 numbers, 6 of weight
    middle, low, high = median_interval(alike)
    assert low <= middle <= high
    assert high - low > 0.5  # of models: that of 120 numbers would be 0.3
    many = median_interval(rng.normal(size=(100, 20)))
    assert many.high - many.low < 0.5
    assert np.isnan(median_interval(np.full((2, 3), np.nan))).all()


def test_no_air_but_the_papers_is_flown_with_models_of_its_own_family_or_flights() -> None:
    assert [plant.air for plant in PLANTS if plant not in JUDGED] == [LAW]
    assert all(plant.family != plant.models for plant in PLANTS)
    assert {plant.air for plant in JUDGED} >= set(SYNTHETIC)
    air = find_air(ROOM)
    assert isinstance(air, RoomAir)
    assert air.flights
    assert all(name.startswith(PASSAGE.plant.family) for name in air.flights)
    assert {plant.air for plant in JUDGED} <= shipped().airs.keys()
    for plant in JUDGED:
        flights = set(shipped().airs[plant.air])
        learned = {one.name for one in shipped().models[plant.models]}
        assert not any(flight in name for flight in flights for name in learned)


@pytest.mark.parametrize("name", PATHS)
def test_the_flown_part_of_the_paths_is_the_scenarios_own_with_all_of_its_passages(name: str) -> None:
    paths = PATHS[name]
    t = np.arange(0.0, paths.end - paths.start, 0.01)
    for cut, scenario in zip(scenarios_of(name), paths.scenarios, strict=True):
        whole, part = plan_of(library.load(scenario)), plan_of(cut)
        assert cut.vehicle.name == "crazyflie_2_0"
        assert cut.overrides["pid"]["k_p_z"] == 10.0
        assert cut.imu.acc_noise == REAL_FLIGHTS.noise
        for own, given in zip(part.trajectories, whole.trajectories, strict=True):
            np.testing.assert_allclose(own.at(t), given.at(t + paths.start), atol=1e-9)
        assert under_ticks(whole.trajectories) == under_ticks(part.trajectories) > 0


def under_ticks(trajectories: tuple[Trajectory, ...]) -> int:
    """Return how many ticks vehicles are under another."""
    t = np.arange(0.0, max(one.duration for one in trajectories), 0.01)
    pos = np.stack([one.at(t)[:, :3] for one in trajectories], axis=1)
    return int(exposure(pos, t).under.sum())


def test_places_of_draws_are_out_of_reach_and_their_paths_the_same() -> None:
    one = scenarios_of("crossing")
    scenario = side_by_side(one, 7)
    starts = np.array([vehicle.points[0] for vehicle in scenario.waypoints]).reshape(7, 2, 4)
    aside = starts[:, 0, :2] - starts[0, 0, :2]
    apart = np.linalg.norm(aside[:, None] - aside, axis=2)[~np.eye(7, dtype=np.bool_)]
    assert apart.min() == pytest.approx(SPACING)
    np.testing.assert_allclose(starts - starts[:, :1], starts[:1] - starts[:1, :1] + np.zeros((7, 1, 1)))
    third = with_vehicles(scenario, scenario.names[4:6])
    assert plan_of(third).names == scenario.names[4:6] == third.names


def test_a_part_of_a_trajectory_begins_and_ends_where_it_is_cut() -> None:
    whole = plan_of(library.load("crossing")).trajectories[0]
    part = trajectory_between(whole, 17.0, 34.5)
    assert part.duration == pytest.approx(17.5)
    ends = np.array([0.0, 17.5])
    for derivative in range(3):
        np.testing.assert_allclose(part.at(ends, derivative), whole.at(ends + 17.0, derivative), atol=1e-9)


def samples(exposed: int) -> PushSamples:
    """Return samples of which the first `exposed` are under another vehicle."""
    t, rows = 0.01 * np.arange(2500), np.arange(2500)
    motion = Motion(t, np.zeros((2500, 2, 3)), np.zeros((2500, 2, 3)), np.zeros((2500, 2, 3)))
    return PushSamples("one", motion, 0, t, rows < 0, rows < exposed, rows < 0)


@pytest.mark.parametrize(("count", "parts"), [(0, 0), (LEAST - 1, 0), (LEAST, 1), (3 * LEAST + 5, 3)])
def test_parts_of_a_flight_share_no_sample_and_leave_none(count: int, parts: int) -> None:
    found = parts_of([samples(count)])
    assert len(found) == parts
    if found:
        times = np.array([one.exposed for (one,) in found]).sum(axis=0)
        np.testing.assert_array_equal(times, samples(count).exposed.astype(int))
        assert min(one.exposed.sum() for (one,) in found) >= LEAST


@pytest.mark.skipif(not DATA.is_dir(), reason=f"real flights are not at {DATA}: set Q2Q_DATA")
def test_a_model_behind_the_page_is_the_one_that_its_flight_gives(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    name = "dc19_swap_ss_02"
    monkeypatch.setenv("Q2Q_DATA", str(tmp_path))
    (tmp_path / FLIGHTS).mkdir()
    (tmp_path / FLIGHTS / f"{name}.parquet").symlink_to((DATA / FLIGHTS / f"{name}.parquet").resolve())
    found, every = models_of("dc19")
    (kept,) = (one for one in shipped().models["dc19"] if one.name == name)
    assert (found.name, every.name) == (name, "dc19, all flights")
    # the page was made before derivatives of a fit were central differences (docs/ablation.md)
    assert peak_downwash(found.jet) == pytest.approx(peak_downwash(kept.jet), rel=5e-3)


def test_absent_flights_are_named_with_what_to_do(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("Q2Q_DATA", str(tmp_path))
    with pytest.raises(ValueError, match=re.escape("no recorded flights dc19 in ") + ".*set Q2Q_DATA"):
        models_of("dc19")
    assert learned_models.FORM.carried == 1.0
    assert models_of(LAW)[0].jet == PAPER_LAW
    assert models_of(LAW)[0].process == REAL_FLIGHTS
