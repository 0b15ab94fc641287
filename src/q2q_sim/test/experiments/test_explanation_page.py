"""The page of an explanation: its sentence, both flights, and what its intervals are of."""

from dataclasses import replace
from pathlib import Path

import pytest
from explained_flights import FOUND, short

from q2q_sim.experiments.explanation.explanation import CauseShare
from q2q_sim.experiments.explanation.explanation_page import write_page
from q2q_sim.experiments.explanation.explanation_sentence import explanation_sentence
from q2q_sim.experiments.explanation.flight_setup import fly_setup
from q2q_sim.experiments.explanation.recorded_setup import RecordedSetup


def test_a_page_shows_the_sentence_first_and_both_flights(tmp_path: Path) -> None:
    setup = short("stack3")
    file = write_page(FOUND, RecordedSetup(setup, fly_setup(setup), 1e-13), "a bag", tmp_path)
    page = file.read_text()
    assert (
        page.index(explanation_sentence(FOUND))
        < page.index('"name":"as flown"')
        < page.index('"name":"without downwash"')
    )
    assert "<td>61.0</td><td>55.0</td><td>67.0</td>" in page
    assert "that of other orders and other draws of noise, losses and gusts." in page


def test_a_page_without_a_first_cause_shows_the_flight_alone_and_an_ordinary_one_is_good(
    tmp_path: Path,
) -> None:
    setup = short("stack3")
    recorded = RecordedSetup(setup, fly_setup(setup), 0.0)
    unexplained = replace(FOUND, shares=(), first=None)
    page = write_page(unexplained, recorded, "a bag", tmp_path / "why").read_text()
    assert "Why did cf1 leave its path?" in page
    assert 'class="verdict bad"' in page
    assert '"name":"without' not in page
    ordinary = replace(unexplained, loss=replace(FOUND.loss, kind="distance", size=0.03))
    page = write_page(ordinary, recorded, "a bag", tmp_path / "ordinary").read_text()
    assert "<h1>No vehicle left its path</h1>" in page
    assert 'class="verdict bad"' not in page


@pytest.mark.parametrize(
    ("all_orders", "draws", "note"),
    [
        (False, 1, "The 95 % interval is that of other orders."),
        (True, 2, "The 95 % interval is that of other draws of noise, losses and gusts."),
        (True, 1, "All orders were flown with one seed, so the contributions have no interval."),
    ],
)
def test_a_page_says_what_its_intervals_are_of(
    tmp_path: Path, *, all_orders: bool, draws: int, note: str
) -> None:
    setup = short("stack3")
    nothing = (CauseShare("latency", -1e-5, -2e-5, 1e-5),)
    found = replace(FOUND, shares=nothing, all_orders=all_orders, draws=draws)
    page = write_page(found, RecordedSetup(setup, fly_setup(setup), 0.0), "a bag", tmp_path).read_text()
    assert note in page
    assert "<td>0.0</td><td>0.0</td><td>0.0</td>" in page
