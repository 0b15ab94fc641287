"""The ablation measures what it says: replicas are flights of their own, windows and ratios are right."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from q2q_model.downwash.jet import PAPER_LAW, Jet
from q2q_model.identification.intervals import Interval
from q2q_model.signals.values import Array
from q2q_sim.commands.ablation import main
from q2q_sim.experiments.ablation.ablation_cases import CASES, Case, is_random, scenario_of, side_by_side
from q2q_sim.experiments.ablation.ablation_table import (
    key,
    median_interval,
    page,
    ratio_to_clear_air,
    worst_to_ignoring,
)
from q2q_sim.experiments.ablation.contenders import BLIND, CONTENDERS, built
from q2q_sim.experiments.ablation.fill_table import CAUTION, READING, Results, read
from q2q_sim.experiments.ablation.fill_table import LEARNED as LEARNED_FROM
from q2q_sim.experiments.ablation.learned_model import Learned, pairs_over
from q2q_sim.experiments.ablation.trial import COLUMNS, Trace, flown, measured
from q2q_sim.loop.assembly import Options, blocks_of, plan_of
from q2q_sim.scenarios import library
from q2q_sim.scenarios.scenario import Scenario

LEARNED = Learned(PAPER_LAW, 0.0, None)
SHORT = 0.3
"""Ends before anything but the start of a flight has happened [s]."""


def traced(scenario: Scenario, name: str) -> Trace:
    """Return a flight of a contender that is not the slow-to-make explicit one."""
    plan = plan_of(scenario)
    controller = built(name, (scenario, plan), LEARNED, limited=False)
    blocks = replace(blocks_of(scenario, Options(), PAPER_LAW, plan), controller=controller)
    return flown(scenario, blocks, aware=name not in BLIND)


def test_replicas_in_an_ideal_room_fly_like_one_alone():
    one = replace(library.load("table6"), duration=SHORT)
    alone, four = traced(one, "PD aware"), traced(side_by_side(one, 4), "PD aware")
    # places 10 m off the origin lose two digits of the last bits
    assert np.allclose(four.error, np.tile(alone.error, 4), atol=1e-12)
    assert np.allclose(four.thrust, np.tile(alone.thrust, 4), atol=1e-9)


def test_replicas_in_a_real_room_differ():
    scenario = side_by_side(replace(library.load("stack3"), duration=SHORT), 2)
    trace = traced(scenario, "observer")
    assert np.abs(trace.error[-1, :3] - trace.error[-1, 3:]).min() > 1e-7


def test_a_replica_is_measured_as_its_definition_says():
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


def test_the_interval_of_a_median_holds_it_and_shrinks_with_more_samples():
    rng = np.random.default_rng(0)
    few, many = (median_interval(rng.normal(size=n)) for n in (20, 500))
    assert few[1] <= few[0] <= few[2]
    assert many[2] - many[1] < 0.5 * (few[2] - few[1])
    assert np.isnan(median_interval(np.full(3, np.nan))).all()


def cells_of(case: Case) -> dict[str, Array]:
    """Return made-up results of two contenders."""
    good = np.array([[0.1, 0.2, 0.012, 0.02, 0.010, 1.0], [0.1, 0.2, 0.022, 0.04, 0.020, 1.0]])
    bad = good.copy()
    bad[:, COLUMNS.index("worst")] = [0.2, 0.2]
    return {key(case, "MPC observer"): good, key(case, "ignoring"): bad}


def test_ratios_are_those_of_each_replica():
    cells = cells_of(CASES[0])
    assert np.allclose(ratio_to_clear_air(cells[key(CASES[0], "MPC observer")]), [1.2, 1.1])
    assert np.allclose(worst_to_ignoring(cells, CASES[0], "MPC observer"), [10.0, 5.0])


def test_the_page_has_a_row_for_what_was_flown_and_none_for_the_rest():
    text = page(cells_of(CASES[0]), ["note"], "the command")
    assert "the command" in text
    assert text.count("| MPC observer |") == 1
    assert "| explicit |" not in text


def test_results_are_kept_and_read_again(tmp_path: Path):
    file = tmp_path / "numbers.json"
    learned = Learned(Jet(strength=0.5), 0.25, 0.9, Interval(0.25, 0.125, 0.375))
    results = Results(file, 2, {"paper": learned, "measured": LEARNED}, cells_of(CASES[0]))
    results.save()
    again = read(file, 2)
    assert again.models == results.models
    assert all(np.array_equal(again.cells[name], values) for name, values in results.cells.items())
    with pytest.raises(ValueError, match="holds 2 seeds, not 3"):
        read(file, 3)
    file.write_text("{}")
    with pytest.raises(ValueError, match="is not an ablation"):
        read(file, 2)


def test_the_table_of_an_unfinished_run_can_be_written_without_flying(tmp_path: Path):
    numbers, table = tmp_path / "numbers.json", tmp_path / "table.md"
    Results(numbers, 2, {"measured": LEARNED}, cells_of(CASES[0])).save()
    words = ["--seeds", "2", "--json", str(numbers), "--out", str(table), "--table-only"]
    assert main(words) == 0
    written = table.read_text()
    assert "| ignoring | 2 |" in written
    assert "--table-only" not in written


def test_every_case_has_a_scenario_and_a_name_of_its_own():
    assert len({key(case, name) for case in CASES for name in CONTENDERS}) == len(CASES) * len(CONTENDERS)
    random = {case: is_random(scenario_of(case)) for case in CASES}
    assert not random[Case("table6", "paper")]
    assert random[Case("stack3", "measured")]
    assert scenario_of(Case("table6_room", "measured")).vehicle.name == "crazyflie_2_0"


def test_training_flights_keep_their_vehicles_apart():
    for number in range(3):
        places = np.array([one.points[0][:3] for one in pairs_over(number)])
        gaps = np.linalg.norm(places[:, None] - places[None], axis=-1)
        assert gaps[~np.eye(len(places), dtype=bool)].min() > 0.5


def test_an_unknown_contender_is_refused():
    scenario = library.load("table6")
    with pytest.raises(ValueError, match="unknown contender 'lqr'"):
        built("lqr", (scenario, plan_of(scenario)), LEARNED, limited=True)


def test_the_page_says_what_was_flown_in_what():
    shown = (Path(__file__).resolve().parents[3] / "docs" / "ablation.md").read_text(encoding="utf-8")
    assert [words for words in (READING, CAUTION, LEARNED_FROM) if words not in shown] == []
