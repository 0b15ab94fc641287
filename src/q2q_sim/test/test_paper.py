"""The remade paper: its numbers stand once with their place, rows keep the contract, a broken run goes on."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from q2q_sim.tools import paper
from q2q_sim.tools.paper_cache import PaperCache, fingerprint
from q2q_sim.tools.paper_numbers import chosen, paper_numbers
from q2q_sim.tools.paper_outcome import Experiment, FigurePicture, Line, Outcome, drawn
from q2q_sim.tools.paper_page import as_json, rows, write_page, write_pdf

NUMBERS = paper_numbers()


def test_tables_3_to_7_and_figures_4_to_15_are_all_there():
    groups = {one.group for one in NUMBERS}
    assert {f"table{k}" for k in range(1, 8)} | {f"fig{k}" for k in range(4, 16)} == groups


def test_every_number_has_a_place_and_a_reason():
    for one in NUMBERS:
        assert one.where.lower().startswith(("table", "fig", "section"))
        assert one.note
        assert one.note != "as above"  # a row is read alone


def test_table_6_holds_the_papers_own_numbers():
    found = {one.id: one.paper for one in NUMBERS if one.group == "table6"}
    assert found["table6.q1_z_rmse_ignoring"] == 0.1315
    assert found["table6.q1_z_rmse_aware"] == 0.0280
    assert found["table6.q2_u1_energy_aware"] == 2033.33


def test_reductions_follow_from_the_papers_own_rms():
    of = {one.id: one.paper or math.nan for one in NUMBERS}
    for k in (1, 2):
        less = 100.0 * (1.0 - of[f"fig11.rms_{k}_with"] / of[f"fig11.rms_{k}_without"])
        assert of[f"fig11.reduction_{k}"] == pytest.approx(less, abs=0.05)  # written with one digit


def test_every_group_with_a_number_of_ours_has_an_experiment():
    made = {group for one in paper.EXPERIMENTS for group in one.groups}
    without = {one.group for one in NUMBERS} - made
    assert without == {"table5"}  # settings of a solver that ours does not have: each row says so


def test_only_runs_what_is_asked_for():
    assert [one.name for one in paper.needed(chosen(NUMBERS, "table6"))] == ["pid"]
    assert {one.name for one in paper.needed(chosen(NUMBERS, "table7,fig10"))} == {"pid", "mpc", "planning"}


def test_a_wrong_table_is_answered_with_the_nearest(capsys: pytest.CaptureFixture[str]):
    assert paper.main(["--only", "tabel6"]) == 1
    assert "did you mean table6?" in capsys.readouterr().err


def test_a_number_without_a_place_is_refused(tmp_path: Path):
    (tmp_path / "paper.yaml").write_text("table6.x: {paper: 1.0, unit: m, note: none}\n")
    with pytest.raises(ValueError, match=r"table6\.x"):
        paper_numbers(tmp_path / "paper.yaml")


def test_rows_keep_the_contract_and_say_null_for_what_is_not_a_number():
    told = as_json(
        chosen(NUMBERS, "table1"), [Outcome({"table1.takeoff_weight": 34.0, "table1.size": math.nan})]
    )
    first = json.loads(json.dumps(told, allow_nan=False))["rows"]
    assert set(first[0]) == {"id", "paper", "ours", "unit", "note"}
    of = {row["id"]: row["ours"] for row in first}
    assert of["table1.takeoff_weight"] == 34.0
    assert of["table1.size"] is None


def test_the_ratio_is_ours_over_the_papers():
    cells = rows(chosen(NUMBERS, "table6"), [Outcome({"table6.q1_z_rmse_ignoring": 0.263})])
    row = next(cell for cell in cells if cell[0] == "table6.q1_z_rmse_ignoring")
    assert row[2:5] == ("0.1315", "0.263", "2")


def test_a_finished_experiment_is_not_run_again_and_a_broken_one_is(tmp_path: Path):
    ran: list[str] = []

    def good(folder: Path) -> Outcome:
        ran.append("good")
        file = drawn(folder / "fig4.png", "t", ("x", "y"), [Line("a", np.arange(3.0), np.arange(3.0))])
        return Outcome({"fig4.d": 1.0}, (FigurePicture("fig4", file, "t"),))

    def breaks(_: Path) -> Outcome:
        ran.append("breaks")
        raise KeyboardInterrupt

    both = [Experiment("good", ("fig4",), 1.0, good), Experiment("breaks", ("fig5",), 1.0, breaks)]
    cache = PaperCache(tmp_path, "code 1")
    for _ in range(2):
        with pytest.raises(KeyboardInterrupt):
            paper.run_all(both, cache, again=False)
    assert ran == ["good", "breaks", "breaks"]
    paper.run_all(both[:1], PaperCache(tmp_path, "code 2"), again=False)
    assert ran[-1] == "good"  # other code: run again


@pytest.mark.parametrize("text", ["", "{", '{"code": "1"}', "[]"])
def test_a_damaged_cache_is_no_result(tmp_path: Path, text: str):
    (tmp_path / "cache").mkdir()
    (tmp_path / "cache" / "one.json").write_text(text)
    assert PaperCache(tmp_path, "1").load("one") is None


def test_a_cached_outcome_without_its_picture_is_no_result(tmp_path: Path):
    cache = PaperCache(tmp_path, "1")
    cache.save("one", Outcome({}, (FigurePicture("fig4", "gone.png", "t"),)))
    assert cache.load("one") is None


def test_the_fingerprint_is_the_same_for_the_same_code():
    assert fingerprint() == fingerprint()


def test_page_and_pdf_hold_every_row_and_picture(tmp_path: Path):
    file = drawn(
        tmp_path / "learning" / "fig4.png", "t", ("x", "y"), [Line("a", np.arange(3.0), np.arange(3.0))]
    )
    outcome = Outcome({"fig4.d": 2.5}, (FigurePicture("fig4", file, "dev falls"),))
    asked = chosen(NUMBERS, "fig4,table6")
    write_page(asked, [outcome], tmp_path)
    write_pdf(asked, [outcome], tmp_path)
    text = (tmp_path / "index.html").read_text()
    assert all(f">{one.id}</td>" in text for one in asked)
    assert text.count("<img ") == 1
    assert (tmp_path / "paper.pdf").read_bytes().startswith(b"%PDF")


def test_the_vehicle_rows_are_the_vehicles_own_constants(tmp_path: Path):
    assert paper.EXPERIMENTS[0].run(tmp_path).values["table1.inertia_zz"] == 7.06e-5
