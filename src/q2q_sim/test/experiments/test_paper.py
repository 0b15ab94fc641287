"""The remade paper: its numbers stand once with their place, rows keep the contract, a broken run goes on."""

import html
import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml

from q2q_model.identification.gains.altitude_from_flight import altitude_record
from q2q_model.identification.networks.trajectory_loss import WIDE, flight_terms
from q2q_model.vehicle.altitude_loop import AltitudeLoop
from q2q_model.vehicle.constants import CRAZYFLIE_2_0
from q2q_sim.commands.paper import main as command_of_paper
from q2q_sim.experiments.paper import learning_tables, reproduction, tracking_tables
from q2q_sim.experiments.paper.experiment_cache import PaperCache, fingerprint
from q2q_sim.experiments.paper.experiment_outcome import (
    Experiment,
    ExperimentOutcome,
    FigurePicture,
    Line,
    plot_panel,
)
from q2q_sim.experiments.paper.paper_numbers import paper_numbers, select_numbers
from q2q_sim.experiments.paper.paper_page import (
    CITATION,
    as_json,
    closeness_sentence,
    table_cells,
    without_repeated_notes,
    write_page,
    write_pdf,
)
from q2q_sim.loop.closed_loop import FlightOptions, fly
from q2q_sim.scenarios import library

NUMBERS = paper_numbers()
ROOT = Path(__file__).resolve().parents[4]


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
    made = {group for one in reproduction.EXPERIMENTS for group in one.groups}
    without = {one.group for one in NUMBERS} - made
    assert without == set()


def test_a_hover_lasts_until_the_charge_of_the_low_voltage_and_the_firmwares_patience():
    left = 0.1 * (3.2 - 3.00) / (3.78 - 3.00)  # the curve's first piece
    assert learning_tables.hover_time() == pytest.approx(420.0 * (1.0 - left) + 5.0, abs=0.3)  # 3 steps


def test_adams_first_step_is_its_rate():
    flight = fly(library.load("table2_3"), FlightOptions(mode="ignoring"))
    loop = AltitudeLoop(k_p=0.81, k_d=0.43)
    near = flight_terms(altitude_record(flight, CRAZYFLIE_2_0), loop, (WIDE * 0.1, WIDE * 1.1))
    step, seconds = learning_tables.timed_adam([near])
    assert step == pytest.approx(1e-4, rel=1e-3)  # 1e-8 in Adam's denominator
    assert seconds > 0.0


def test_fig_4_draws_the_flights_alone_where_they_show_no_decay(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
):
    drawn: list[Line] = []

    def noted(path: Path, _: str, __: tuple[str, str], lines: list[Line]) -> str:
        drawn.extend(lines)
        return path.name

    monkeypatch.setattr(learning_tables, "plot_panel", noted)
    decay = learning_tables.known_decay([])
    learning_tables.decay_picture(tmp_path, [], decay)
    assert decay is None
    assert [(line.label, line.x.shape, line.y.shape) for line in drawn] == [("flights", (0,), (0,))]


def test_fig_15_draws_the_mpc_and_the_pd(monkeypatch: pytest.MonkeyPatch, tmp_path: Path):
    labels: list[list[str]] = []

    def noted(path: Path, _: str, __: tuple[str, str], lines: list[Line]) -> str:
        labels.append([line.label for line in lines])
        return path.name

    short = replace(library.load("table6"), duration=0.3)
    monkeypatch.setattr(tracking_tables.library, "load", lambda _: short)
    monkeypatch.setattr(tracking_tables, "plot_panel", noted)
    found = tracking_tables.mpc(tmp_path)
    assert labels[0] == ["aware MPC", "aware PD", "reference"]
    assert labels[1] == ["aware MPC", "aware PD"]
    assert {"fig15.q1_dip", "fig15.q1_dip_pd"} <= found.values.keys()


def test_rows_that_only_repeat_a_constant_or_a_condition_say_so():
    echoed = {"table1.takeoff_weight", "table1.inertia_xx", "table1.inertia_yy", "table1.inertia_zz"}
    echoed |= {"table1.size", "table3.xtol", "table3.ftol", "table4.step_size"}
    echoed |= {"fig5.k_p_from_commands", "fig5.k_d_from_commands"}
    echoed |= {f"table2.{what}_{k}" for what in ("distance", "speed", "overlap") for k in range(1, 7)}
    assert {one.id for one in NUMBERS if "no result" in one.note} == echoed


def test_only_runs_what_is_asked_for():
    def names(only: str) -> list[str]:
        return [one.name for one in reproduction.needed_experiments(select_numbers(NUMBERS, only))]

    assert names("table6") == ["pid"]
    assert set(names("table7,fig10")) == {"pid", "mpc", "planning"}


def test_a_wrong_table_is_answered_with_the_nearest(capsys: pytest.CaptureFixture[str]):
    assert command_of_paper(["--only", "tabel6"]) == 1
    assert "did you mean table6?" in capsys.readouterr().err


def test_a_number_without_a_place_is_refused(tmp_path: Path):
    (tmp_path / "paper.yaml").write_text("table6.x: {paper: 1.0, unit: m, note: none}\n")
    with pytest.raises(ValueError, match=r"table6\.x"):
        paper_numbers(tmp_path / "paper.yaml")


def test_rows_keep_the_contract_and_say_null_for_what_is_not_a_number():
    output = as_json(
        select_numbers(NUMBERS, "table1"),
        [ExperimentOutcome({"table1.takeoff_weight": 34.0, "table1.size": math.nan})],
    )
    first = json.loads(json.dumps(output, allow_nan=False))["rows"]
    assert set(first[0]) == {"id", "paper", "ours", "unit", "note"}
    of = {row["id"]: row["ours"] for row in first}
    assert of["table1.takeoff_weight"] == 34.0
    assert of["table1.size"] is None


def test_the_ratio_is_ours_over_the_papers():
    cells = table_cells(
        select_numbers(NUMBERS, "table6"), [ExperimentOutcome({"table6.q1_z_rmse_ignoring": 0.263})]
    )
    row = next(cell for cell in cells if cell[0] == "table6.q1_z_rmse_ignoring")
    assert row[1:4] == ("0.1315", "0.263", "2")


def test_a_page_repeats_no_note_of_the_row_above() -> None:
    cells = [("a", "flown"), ("b", "flown"), ("c", "taken"), ("d", "flown")]
    assert [row[-1] for row in without_repeated_notes(cells)] == ["flown", "as above", "taken", "flown"]


def test_small_numbers_and_units_are_printed_with_powers():
    cells = table_cells(
        select_numbers(NUMBERS, "table1"), [ExperimentOutcome({"table1.inertia_xx": 3.144e-5})]
    )
    row = next(cell for cell in cells if cell[0] == "table1.inertia_xx")
    assert row[1:5] == ("3.14 · 10⁻⁵", "3.14 · 10⁻⁵", "1", "kg m²")


def test_numbers_taken_from_the_paper_do_not_count_as_close_to_it():
    asked = select_numbers(NUMBERS, "table1,table6")
    found = {
        "table1.takeoff_weight": 34.0,
        "table6.q1_z_rmse_ignoring": 0.1315,
        "table6.q1_z_rmse_aware": 0.28,
    }
    assert closeness_sentence(asked, [ExperimentOutcome(found)]).startswith(
        "Within 10 % of the paper's: 1 of 2 numbers"
    )


def test_a_finished_experiment_is_not_run_again_and_a_broken_one_is(tmp_path: Path):
    ran: list[str] = []

    def good(folder: Path) -> ExperimentOutcome:
        ran.append("good")
        file = plot_panel(folder / "fig4.png", "t", ("x", "y"), [Line("a", np.arange(3.0), np.arange(3.0))])
        return ExperimentOutcome({"fig4.d": 1.0}, (FigurePicture("fig4", file, "t"),))

    def breaks(_: Path) -> ExperimentOutcome:
        ran.append("breaks")
        raise KeyboardInterrupt

    both = [Experiment("good", ("fig4",), 1.0, good), Experiment("breaks", ("fig5",), 1.0, breaks)]
    cache = PaperCache(tmp_path, "code 1")
    for _ in range(2):
        with pytest.raises(KeyboardInterrupt):
            reproduction.run_all(both, cache, again=False)
    assert ran == ["good", "breaks", "breaks"]
    reproduction.run_all(both[:1], PaperCache(tmp_path, "code 2"), again=False)
    assert ran[-1] == "good"  # other code: run again


@pytest.mark.parametrize("text", ["", "{", '{"code": "1"}', "[]"])
def test_a_damaged_cache_is_no_result(tmp_path: Path, text: str):
    (tmp_path / "cache").mkdir()
    (tmp_path / "cache" / "one.json").write_text(text)
    assert PaperCache(tmp_path, "1").load("one") is None


def test_a_cached_outcome_without_its_picture_is_no_result(tmp_path: Path):
    cache = PaperCache(tmp_path, "1")
    cache.save("one", ExperimentOutcome({}, (FigurePicture("fig4", "gone.png", "t"),)))
    assert cache.load("one") is None


def test_the_numbers_name_the_module_of_their_experiments():
    text = Path(reproduction.__file__).with_name("paper.yaml").read_text()
    assert f"in {reproduction.__name__};" in text


@pytest.mark.parametrize("shipped", ["q2q_model/config/law.q2q", "q2q_sim/config/room.air"])
def test_a_shipped_model_or_air_that_changes_changes_the_fingerprint(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, shipped: str
):
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path))
    file = tmp_path / "share" / shipped
    file.parent.mkdir(parents=True)
    file.write_bytes(b"1")
    before = fingerprint()
    file.write_bytes(b"2")
    assert fingerprint() != before


def test_page_and_pdf_hold_every_row_and_picture(tmp_path: Path):
    file = plot_panel(
        tmp_path / "learning" / "fig4.png", "t", ("x", "y"), [Line("a", np.arange(3.0), np.arange(3.0))]
    )
    outcome = ExperimentOutcome({"fig4.d": 2.5}, (FigurePicture("fig4", file, "dev falls"),))
    asked = select_numbers(NUMBERS, "fig4,table6")
    write_page(asked, [outcome], tmp_path)
    write_pdf(asked, [outcome], tmp_path)
    text = (tmp_path / "index.html").read_text().replace("<wbr>", "")
    assert all(f">{one.id}</td>" in text for one in asked)
    assert text.count("<img ") == 1
    assert html.escape(CITATION) in text
    assert (tmp_path / "paper.pdf").read_bytes().startswith(b"%PDF")


def test_the_vehicle_rows_are_the_vehicles_own_constants(tmp_path: Path):
    assert reproduction.EXPERIMENTS[0].run(tmp_path).values["table1.inertia_zz"] == 7.06e-5


@pytest.mark.parametrize("document", ["README.md", "docs/README.md"])
def test_documents_name_the_paper_in_full(document: str):
    assert CITATION in " ".join((ROOT / document).read_text(encoding="utf-8").split())


def test_the_citation_file_names_the_same_paper():
    cff = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert {"cff-version", "message", "title", "authors"} <= cff.keys()  # what the 1.2.0 schema requires
    paper_cited = cff["preferred-citation"]
    names = [
        f"{one['given-names'][0]}. {one.get('name-particle', '')} {one['family-names']}"
        for one in paper_cited["authors"]
    ]
    output = f"{', '.join(' '.join(name.split()) for name in names)}: {paper_cited['title']}. "
    assert f"{output}{paper_cited['journal']} {paper_cited['volume']} ({paper_cited['year']})." == CITATION
