"""The page of the ablation follows its numbers, which are kept and read again."""

from pathlib import Path

import numpy as np
import pytest
from ablation_numbers import PASSAGE, ROOT, STACK, shipped

from q2q_model.downwash.correction.residual_process import ResidualProcess
from q2q_model.downwash.jet import Jet
from q2q_sim.air.air_names import ROOM
from q2q_sim.commands.ablation import main
from q2q_sim.experiments.ablation.ablation_cases import (
    CASES,
    JUDGED,
    PATHS,
    PLANTS,
    SHOWN,
    Case,
)
from q2q_sim.experiments.ablation.ablation_numbers import Numbers, cell_name, read_numbers
from q2q_sim.experiments.ablation.ablation_table import ablation_page
from q2q_sim.experiments.ablation.conclusion import (
    best_variant,
    conclusion,
    median_ratio,
    missed_targets,
    worse_than_ignoring,
)
from q2q_sim.experiments.ablation.learned_models import MOST, LearnedModel
from q2q_sim.experiments.ablation.variant_flight import COLUMNS
from q2q_sim.experiments.ablation.variants import NAMES, ONBOARD, TWINS, VARIANTS


def numbers_of(**under: float) -> Numbers:
    """Return made-up numbers of two models: rms [m] under another by variant, worst 3 times that."""
    parts = [LearnedModel(f"{k}", Jet(), ResidualProcess(floor=0.1 * k)) for k in (1, 2, 3)]
    made = Numbers(1, {plant.models: parts for plant in PLANTS}, {ROOM: ["dc21_x"]})
    for case in CASES:
        for name in NAMES:
            rms = under.get(name.replace(" ", "_"), 0.02)
            count = len(case.paths.scenarios) * (5 if case.paths.draws else 2)
            rows = [[rms, 0.01, 3.0 * rms]] * count
            made.flights[cell_name(case, name)] = np.array(rows) * (1.0 + 0.1 * np.arange(count))[:, None]
    return made


def test_draws_are_sorted_by_their_model() -> None:
    made = numbers_of(ignoring=0.1)
    cell = made.cell(PASSAGE, "ignoring")
    assert cell is not None
    np.testing.assert_allclose(cell[..., 0], [[0.1], [0.11]])  # two models of parts, a draw each
    six = made.cell(Case("table2"), "ignoring")
    assert six is not None
    assert six.shape == (1, 30, 3)  # the model of all flights
    made.draws = 4
    assert made.draws_of(PASSAGE) == 4 * MOST
    assert made.draws_of(Case("table2")) == 5


def test_ratios_are_those_of_each_draw() -> None:
    made = numbers_of(ignoring=0.09)
    assert median_ratio(made, PASSAGE, ("ignoring", "MPC"), "worst") == pytest.approx((4.5, 4.5, 4.5))


def test_the_conclusion_follows_the_numbers() -> None:
    made = numbers_of(ignoring=0.09, MPC=0.01, aware=0.1)
    assert best_variant(made, PASSAGE) == "MPC"
    assert missed_targets(made, PASSAGE, "MPC") == []
    assert best_variant(numbers_of(ignoring=0.09, integral=0.011, observer=0.01), PASSAGE) == "observer"
    assert missed_targets(made, PASSAGE, "integral") == ["gain 4.5", "21 mm rms", "63 mm worst"]
    assert missed_targets(made, PASSAGE, "ignoring")[0] == "under / clear 9.0"
    assert worse_than_ignoring(made, STACK) == ["aware"]
    said = conclusion(made)
    every = f"{2 * len(JUDGED)} of {2 * len(JUDGED)} pairs"
    assert f"**MPC** is the best controller in {every} of paths and air model." in said
    assert "32 to 32 mm in `stack3` (*ignoring*: 284 to 284 mm)" in said
    assert "| aware | ignoring | 1.11 (1.11 to 1.11) |" in said
    assert "| MPC | aware + observer | 0.50 (0.50 to 0.50) |" in said
    assert f"The best one meets all targets in {every}: " in said
    judged = f"On all paths ({len(PATHS) * len(JUDGED)} pairs)"
    assert f"{judged} these have a larger rms error under another vehicle than *ignoring*: aware in" in said
    assert ": aware in table6_room, air room (1.11 times, 1.11 to 1.11); aware in" in said
    assert f"{judged} no controller has a larger rms error" in conclusion(numbers_of(ignoring=0.09))
    elsewhere = numbers_of(ignoring=0.09)
    elsewhere.flights[cell_name(Case("crossing"), "observer")] *= 5.0  # 0.1 m in paths that are not shown
    assert ": observer in crossing, air room (1.11 times" in conclusion(elsewhere)
    assert len([line for line in said.splitlines() if line.startswith("- ")]) == 4
    del made.flights[cell_name(PASSAGE, "MPC")]
    assert f"in {2 * len(JUDGED) - 1} of {2 * len(JUDGED) - 1} pairs" in conclusion(made)
    assert conclusion(Numbers(2)) == ""


def test_variants_that_differ_by_one_part_are_all_flown() -> None:
    assert {name for pair in TWINS for name in pair} <= set(NAMES)
    assert set(NAMES) == set(VARIANTS) | set(ONBOARD)
    assert [name for name, one in VARIANTS.items() if not one.aware] == ["ignoring", "integral", "observer"]


def test_the_page_has_a_cell_for_what_was_flown_and_none_for_the_rest() -> None:
    made = numbers_of(ignoring=0.09)
    del made.flights[cell_name(PASSAGE, "on board")]
    text = ablation_page(made, "the command", "images/a.png")
    assert "the command" in text
    assert "1 flight not flown" in text
    tables = len(PATHS) + len(PLANTS) * len(SHOWN) + 1  # the last is that of the parts
    assert text.count("\n| MPC + correction |") == tables
    assert text.count("\n| on board |") == tables - 1
    assert "| on board | - |" in text
    assert "0.30 + 0.10 eta" in text


def test_numbers_are_kept_and_read_again(tmp_path: Path) -> None:
    file, made = tmp_path / "numbers.json", numbers_of(ignoring=0.123456789)
    made.save(file)
    again = read_numbers(file, 1)
    assert (again.models, again.airs) == (made.models, made.airs)
    cell = again.cell(PASSAGE, "ignoring")
    assert cell is not None
    assert cell[1, 0, COLUMNS.index("under")] == pytest.approx(1.1 * 0.123456789, rel=5e-3)  # three digits
    with pytest.raises(ValueError, match="holds 1 draws, not 3"):
        read_numbers(file, 3)
    file.write_text("{}")
    with pytest.raises(ValueError, match="is not an ablation"):
        read_numbers(file, 1)


def test_the_page_of_an_unfinished_run_can_be_written_without_flying(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file, out = tmp_path / "numbers.json", tmp_path / "page.md"
    made = numbers_of(ignoring=0.09)
    del made.flights[cell_name(STACK, "on board")]
    made.save(file)
    asked = ["--draws", "1", "--json", str(file), "--out", str(out), "--table-only"]
    assert main(asked) == 0
    written = out.read_text()
    assert "1 flight not flown" in written
    assert "--table-only" not in written
    assert (tmp_path / "images" / "page.png").stat().st_size > 10_000
    assert main([*asked, "--airs", "rom"]) == 1
    assert "--airs rom: choose some of bent," in capsys.readouterr().err


def test_a_page_without_flights_replaces_no_other(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file, out = tmp_path / "none.json", tmp_path / "page.md"
    out.write_text("of other numbers")
    assert main(["--json", str(file), "--out", str(out), "--table-only"]) == 1
    assert capsys.readouterr().err == f"ablation: {file} holds no flights: leave out --table-only\n"
    assert out.read_text() == "of other numbers"


def test_the_page_in_the_documents_is_that_of_its_numbers() -> None:
    shown = (ROOT / "docs" / "ablation.md").read_text(encoding="utf-8")
    command = shown.split("`")[1]
    assert ablation_page(shipped(), command, "images/ablation.png") == shown
