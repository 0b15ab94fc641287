"""Perturbations change what they say, and the page of the robustness shows what is worse than ignoring."""

import json
from argparse import Namespace
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from q2q_model.downwash.jet import MEASURED_LAW, PAPER_LAW
from q2q_sim.commands.robustness import AIRS
from q2q_sim.experiments.ablation.side_by_side import side_by_side
from q2q_sim.experiments.robustness.fill_robustness import (
    FlightDraws,
    KeptNumbers,
    asked_flights,
    read,
    run,
    save,
)
from q2q_sim.experiments.robustness.perturbations import (
    GAP,
    PASSAGE,
    PERTURBATIONS,
    Perturbation,
    assumed_model,
    flown_room,
)
from q2q_sim.experiments.robustness.perturbed_flight import Errors, PerturbedFlight, fly_perturbed
from q2q_sim.experiments.robustness.robustness_page import flight_key, ignoring_flight, page
from q2q_sim.scenarios import library

DOCS = Path(__file__).resolve().parents[4] / "docs"
FLIGHTS = asked_flights(["ring", "bent"], 1, 5)


def test_the_believed_downwash_is_stronger_and_later_as_asked() -> None:
    late = assumed_model(MEASURED_LAW, Perturbation("", strength=1.5, delay=0.05))
    assert late.strength == pytest.approx(1.5 * MEASURED_LAW.strength)
    assert GAP / late.travel_speed - GAP / MEASURED_LAW.travel_speed == pytest.approx(0.05)
    assert GAP / assumed_model(PAPER_LAW, Perturbation("", delay=0.05)).travel_speed == pytest.approx(0.05)
    assert GAP / assumed_model(MEASURED_LAW, Perturbation("", delay=-0.5)).travel_speed == pytest.approx(1e-3)


def test_the_flown_room_has_the_faults_of_every_draw_and_another_latency() -> None:
    scenario = side_by_side([library.load(PASSAGE)], 2)
    weak = next(one for one in PERTURBATIONS if one.faults and one.faults[0].kind == "battery_sag")
    (fault,) = flown_room(scenario, replace(weak, latency=0.015)).faults
    assert fault.vehicles == ("cf1_0", "cf1_1")
    late = flown_room(scenario, Perturbation("", latency=0.015))
    assert late.radio.latency - scenario.radio.latency == pytest.approx(0.015)


def test_a_flight_is_compared_with_one_in_the_same_room_that_ignores_the_downwash() -> None:
    assert len({flight_key(one) for one in FLIGHTS}) == len(FLIGHTS)
    shared = {
        flight_key(ignoring_flight(one)) for one in FLIGHTS if one.air == "ring" and one.controller == "mpc"
    }
    assert len(shared) == 6  # as it is, two latencies, an unseen neighbour, a weak battery, a stack


def test_the_page_names_what_is_worse_than_ignoring_and_nothing_else() -> None:
    found = {flight_key(ignoring_flight(one)): Errors(0.1, 0.2, 0.004) for one in FLIGHTS}
    found |= {flight_key(one): Errors(0.05, 0.1, 0.005) for one in FLIGHTS}
    assert "Under another vehicle never worse than without compensation." in page(found, FLIGHTS, "made")
    bad = next(one for one in FLIGHTS if one.perturbation.silent and one.air == "bent")
    found[flight_key(bad)] = Errors(0.106, 0.1, 0.005)
    text = page(found, FLIGHTS, "made")
    assert "Worse under another vehicle than without compensation: no accelerometers in `bent`." in text
    assert text.count("**106.0 (1.06)**") == 1
    assert text.count("| 50.0 (0.50) | 50.0 (0.50) | 5, 4 |") == 23  # the other rows of two controllers


def test_numbers_are_kept_in_a_file(tmp_path: Path) -> None:
    errors = {"a": Errors(0.012345, 0.5, 1e-3), "b": Errors(1.0, 2.0, 3.0)}
    for kept in (KeptNumbers(errors, FlightDraws(2, 2001)), KeptNumbers(errors, FlightDraws(1, 0), "today")):
        save(kept, tmp_path / "numbers.json")
        assert read(tmp_path / "numbers.json") == kept
    for bad in ("[1]", '{"a": [0.1, 0.2, 0.3]}'):
        (tmp_path / "bad.json").write_text(bad)
        with pytest.raises(ValueError, match=r"bad\.json has no results of flights"):
            read(tmp_path / "bad.json")


def test_numbers_of_other_draws_are_refused_and_nothing_is_flown(tmp_path: Path) -> None:
    kept = tmp_path / "numbers.json"
    save(KeptNumbers({}, FlightDraws(2, 2001)), kept)
    before = kept.read_bytes()
    asked = Namespace(airs=["ring"], draws=25, seed=7, json=kept, out=tmp_path / "page.md", table_only=False)
    with pytest.raises(ValueError, match=r"was made with --draws 2 --seed 2001: give these, or another file"):
        run(asked)
    assert kept.read_bytes() == before


def test_an_error_that_no_draw_shows_is_null_in_the_file_and_not_a_number_when_read(tmp_path: Path) -> None:
    kept = tmp_path / "numbers.json"
    save(KeptNumbers({"cell": Errors(float("nan"), 0.25, 0.5)}, FlightDraws(2, 2001)), kept)
    assert json.loads(kept.read_text(encoding="utf-8"))["cell"] == [None, 0.25, 0.5]
    np.testing.assert_array_equal(read(kept).errors["cell"], (np.nan, 0.25, 0.5))


def test_a_vehicle_that_only_the_correction_leaves_on_the_floor_is_worse() -> None:
    nan = float("nan")
    found = {flight_key(ignoring_flight(one)): Errors(0.05, 0.2, 0.004) for one in FLIGHTS}
    found |= {flight_key(one): Errors(nan, nan, 0.005) for one in FLIGHTS}
    text = page(found, FLIGHTS, "made")
    assert "Under another vehicle never worse than without compensation." not in text
    assert "| **floor** | **floor** |" in text
    found |= {flight_key(ignoring_flight(one)): Errors(nan, nan, 0.004) for one in FLIGHTS}
    assert "Under another vehicle never worse than without compensation." in page(found, FLIGHTS, "made")


def test_a_flight_in_which_nobody_was_under_another_has_no_such_error(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("q2q_sim.experiments.robustness.perturbed_flight.DURATION", 0.3)
    found = fly_perturbed(PerturbedFlight("ring", PERTURBATIONS[0], "pid", corrects=True, draws=1, seed=0))
    assert np.isnan(found.under)
    assert found.left < 0.005


def test_the_page_in_the_documents_is_that_of_its_numbers() -> None:
    shown, kept = (DOCS / "robustness.md").read_text(encoding="utf-8"), read(DOCS / "robustness.json")
    flights = asked_flights(list(AIRS), kept.draws.each, kept.draws.seed)
    assert page(kept.errors, flights, shown.split("`")[1], kept.flown) == shown
