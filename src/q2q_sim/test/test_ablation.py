"""The ablation measures what it says: draws are flights of their own, plant and model share no flight."""

import os
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from q2q_model.downwash.jet import PAPER_LAW, Jet
from q2q_model.identification.force.along_flight import Motion
from q2q_model.identification.force.downwash_force import ForceSamples
from q2q_sim.air.air_names import FLIGHTS
from q2q_sim.air.find_air import find_air
from q2q_sim.air.room_air import RoomAir, WindTerm
from q2q_sim.commands.ablation import main
from q2q_sim.experiments.ablation import learned_models
from q2q_sim.experiments.ablation.ablation_cases import CASES, SHIPPED, Case, scenario_of, side_by_side
from q2q_sim.experiments.ablation.ablation_numbers import Numbers, key, read
from q2q_sim.experiments.ablation.ablation_table import SHOWN, page
from q2q_sim.experiments.ablation.conclusion import (
    best_contender,
    conclusion,
    not_smaller,
    ratio,
    worse_than_ignoring,
)
from q2q_sim.experiments.ablation.contender_flight import COLUMNS, Trace, flown, measured
from q2q_sim.experiments.ablation.contenders import CONTENDERS, TWINS, Situation
from q2q_sim.experiments.ablation.learned_models import LEAST, LearnedModel, models_of, parts_of
from q2q_sim.experiments.ablation.two_level_interval import median_interval
from q2q_sim.loop.assembly import Options, blocks_of, plan_of
from q2q_sim.loop.closed_loop import FlightOptions
from q2q_sim.scenarios.scenario import Scenario

ROOT = Path(__file__).resolve().parents[3]
DATA = Path(os.environ.get("Q2Q_DATA", ROOT.parent / "shared" / "data"))
DRAWS = 4
"""Draws with each model behind the page in the documents."""
SHORT = 0.3
"""Ends before anything but the start of a flight has happened [s]."""


def shipped() -> Numbers:
    """Return the numbers behind the page in the documents."""
    return read(ROOT / "docs" / "ablation.json", DRAWS)


def traced(scenario: Scenario, name: str, air: RoomAir) -> Trace:
    """Return a flight of a contender that is not the slow-to-make explicit one."""
    plan, contender = plan_of(scenario), CONTENDERS[name]
    controller = contender.built(Situation(scenario, plan, PAPER_LAW))
    blocks = replace(blocks_of(scenario, Options(), PAPER_LAW, plan), controller=controller)
    return flown(scenario, blocks, FlightOptions("aware" if contender.aware else "ignoring", air=air))


def test_draws_in_one_room_have_their_own_gusts_and_none_feels_another() -> None:
    one = replace(scenario_of(CASES[0]), duration=SHORT)
    two, gusts = side_by_side(one, 2), RoomAir(wind=WindTerm((0.0, 0.0, 0.0), 0.2, 0.15))
    trace = traced(two, "observer", gusts)
    assert np.abs(trace.error[-1, :2] - trace.error[-1, 2:]).min() > 1e-7
    still = replace(two, vicon=type(two.vicon)(), radio=type(two.radio)())
    calm = traced(still, "PD aware", RoomAir())
    # places 10 m off the origin lose two digits of the last bits
    np.testing.assert_allclose(calm.error[:, :2], calm.error[:, 2:], atol=1e-12)


def test_a_draw_is_measured_as_its_definition_says() -> None:
    ticks = 1000
    pos = np.zeros((ticks, 2, 3))
    pos[:, 1] = [1.0, 0.0, 0.5]
    pos[400:500, 1, 0] = 0.0
    error = np.full((ticks, 2), 0.01)
    error[450, 0] = -0.2
    error[:300] = 9.0  # settling is not judged
    found = measured(Trace(pos, error, np.full((ticks, 2), 3.0)), 2, 2.0)
    row = dict(zip(COLUMNS, found[0], strict=True))
    assert found.shape == (1, len(COLUMNS))
    assert row["worst"] == pytest.approx(0.2)
    assert row["under"] == pytest.approx(np.sqrt((199 * 0.01**2 + 0.2**2) / 200))
    assert row["clear"] == pytest.approx(0.01)
    assert row["energy"] == pytest.approx(5.0 * 10.0)  # (3^2 - 2^2) N^2 over 10 s


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


def test_no_air_is_flown_with_models_of_its_own_family_or_flights() -> None:
    for plant in {case.plant for case in CASES}:
        assert plant.family != plant.models
    air = find_air(SHIPPED.air)
    assert isinstance(air, RoomAir)
    assert air.flights
    assert all(name.startswith(SHIPPED.family) for name in air.flights)


def test_every_case_is_flown_by_crazyflies_on_its_own_paths() -> None:
    assert len({key(case, name) for case in CASES for name in CONTENDERS}) == len(CASES) * len(CONTENDERS)
    for case in CASES:
        scenario = scenario_of(case)
        assert (scenario.name, scenario.vehicle.name) == (case.scenario, "crazyflie_2_0")
        assert scenario.overrides["pid"]["k_p_z"] == 10.0
        assert scenario.duration >= max(one.times[-1] for one in scenario.waypoints)
    assert all(CONTENDERS[aware].aware and not CONTENDERS[blind].aware for aware, blind in TWINS.items())


def samples(exposed: int) -> ForceSamples:
    """Return samples of which the first `exposed` are under another vehicle."""
    t, rows = 0.01 * np.arange(2500), np.arange(2500)
    motion = Motion(t, np.zeros((2500, 2, 3)), np.zeros((2500, 2, 3)), np.zeros((2500, 2, 3)))
    return ForceSamples("one", motion, 0, t, rows < 0, rows < exposed, rows < 0)


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
    (found,) = models_of(SHIPPED.models)
    (kept,) = (one for one in shipped().models[SHIPPED.models] if one.name == name)
    assert found.name == name
    assert found.jet.strength == pytest.approx(kept.jet.strength, rel=1e-3)
    assert found.jet.width == pytest.approx(kept.jet.width, rel=1e-3)


def test_absent_flights_are_named_with_what_to_do(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("Q2Q_DATA", str(tmp_path))
    with pytest.raises(ValueError, match=re.escape("no recorded flights dc19 in ") + ".*set Q2Q_DATA"):
        models_of("dc19")
    assert learned_models.FORM.carried == 1.0


def numbers_of(**under: float) -> Numbers:
    """Return made-up numbers of both shown cases: rms [m] under another by contender, worst 3 times that."""
    made = Numbers(2, {"dc19": [LearnedModel("a", Jet()), LearnedModel("b", Jet())]}, {"room": ["dc21_x"]})
    for case in SHOWN:
        for name in CONTENDERS:
            rms = under.get(name.replace(" ", "_"), 0.02)
            row = [0.1, 0.2, rms, 3.0 * rms, 0.01, 1.0]
            made.flights[key(case, name)] = {k: np.array([row, row]) * (1.0 + 0.1 * k) for k in (0, 1)}
    return made


def test_ratios_are_those_of_each_draw() -> None:
    made = numbers_of(ignoring=0.09)
    assert ratio(made, CASES[0], ("ignoring", "MPC"), "worst") == pytest.approx((4.5, 4.5, 4.5))


def test_the_conclusion_follows_the_numbers() -> None:
    made = numbers_of(ignoring=0.09, MPC=0.01, explicit=0.01, PD_aware=0.1)
    assert best_contender(made, CASES[0]) == "MPC"
    said = conclusion(made, SHOWN)
    assert said.startswith(
        "- The least worst height error is in `table6_room` that of **MPC** (not told from it: "
    )
    assert "explicit), 9.0 (9.0 to 9.0) times smaller than ignoring's, with 10 (10 to 11) mm rms" in said
    assert "Worse than ignoring under another vehicle: PD aware in `table6_room` (1.11" in said
    assert "PD aware 1.11 (1.11 to 1.11) and 1.11 (1.11 to 1.11) times ignoring's" in said
    assert "MPC's from 10 to 11 mm in `table6_room`" in said
    assert "; the worst error of PD aware in `table6_room` and of PD aware in `stack3` is not shown" in said
    assert not_smaller(made, CASES[0]) == ["PD aware"]
    calm = numbers_of(ignoring=0.09)
    assert worse_than_ignoring(calm, CASES[0]) == []
    assert "No controller is worse than ignoring" in conclusion(calm, SHOWN)
    assert len(said.splitlines()) == 3
    assert conclusion(Numbers(2), SHOWN) == ""


def test_the_page_has_a_row_for_what_was_flown_and_none_for_the_rest() -> None:
    made = numbers_of(ignoring=0.09)
    del made.flights[key(CASES[0], "explicit")][1]
    text = page(made, "the command", "images/a.png")
    assert "the command" in text
    assert f"{9 * (len(CASES) - 2) + 1} rows of the tables are missing" in text
    assert text.count("\n| MPC observer |") == 2
    assert text.count("\n| explicit |") == 1
    assert "learned from 1 flights of the family dc21 (x)" in text


def test_numbers_are_kept_and_read_again(tmp_path: Path) -> None:
    file, made = tmp_path / "numbers.json", numbers_of(ignoring=0.123456789)
    made.save(file)
    again = read(file, 2)
    assert (again.models, again.airs) == (made.models, made.airs)
    cell = again.cell(CASES[0], "ignoring")
    assert cell is not None
    assert cell[1, 0, COLUMNS.index("under")] == pytest.approx(1.1 * 0.123456789, rel=5e-5)  # five digits
    with pytest.raises(ValueError, match="holds 2 seeds, not 3"):
        read(file, 3)
    file.write_text("{}")
    with pytest.raises(ValueError, match="is not an ablation"):
        read(file, 2)


def test_the_page_of_an_unfinished_run_can_be_written_without_flying(tmp_path: Path) -> None:
    file, out = tmp_path / "numbers.json", tmp_path / "page.md"
    made = numbers_of(ignoring=0.09)
    del made.flights[key(Case("stack3"), "explicit")]
    made.save(file)
    assert main(["--seeds", "2", "--json", str(file), "--out", str(out), "--table-only"]) == 0
    written = out.read_text()
    assert "rows of the tables are missing" in written
    assert "--table-only" not in written
    assert (tmp_path / "images" / "page.png").stat().st_size > 10_000


def test_the_page_in_the_documents_is_that_of_its_numbers() -> None:
    shown = (ROOT / "docs" / "ablation.md").read_text(encoding="utf-8")
    command = shown.split("`")[1]
    assert page(shipped(), command, "images/ablation.png") == shown
