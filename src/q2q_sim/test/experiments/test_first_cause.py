"""The first cause of a loss is the unusual one, if several only act together."""

from dataclasses import replace

import pytest

from q2q_sim.experiments.explanation.accidents import INJECTIONS, ordinary_flight
from q2q_sim.experiments.explanation.causes import without_causes
from q2q_sim.experiments.explanation.first_cause import first_cause
from q2q_sim.experiments.explanation.flight_setup import flight_setup
from q2q_sim.experiments.explanation.loss import Loss
from q2q_sim.experiments.explanation.score import answer_accidents, score_json, score_text
from q2q_sim.faults.faults import Fault
from q2q_sim.loop.flight_blocks import BlockChoices
from q2q_sim.random_streams import stream
from q2q_sim.scenarios import library


@pytest.mark.parametrize("cause", INJECTIONS)
def test_an_accident_differs_from_an_ordinary_flight_by_its_cause_alone(cause: str) -> None:
    rng = stream(1, "test")
    before = ordinary_flight(1, rng)
    after = INJECTIONS[cause](before, rng)
    repaired = [without_causes(setup, {cause}) for setup in (before, after)]
    if cause != "downwash":  # it moves the vehicles above cf1
        assert repaired[0].scenario == repaired[1].scenario
    assert after.scenario != before.scenario


def test_first_causes_of_accidents_are_named_first() -> None:
    found = list(answer_accidents(range(2)))
    assert [one.named for one in found] == [one.first for one in found]
    total = score_json(found)
    assert isinstance(total, dict)
    assert (total["accidents"], total["named_first"], total["mistaken"]) == (2, 2, [])
    wrong = replace(found[0], named="wind", first="control")
    assert score_text([*found, wrong]) == "first cause named first in 2 of 3 accidents (67%)"


@pytest.mark.parametrize(("left", "faults", "gusts", "first"), [
    # loss 1 m; shares: wind 0.4, lost messages 0.3, control 0.2
    ({"wind": 0.9, "lost messages": 0.8, "control": 0.7}, (), 0.1, "wind"),  # takes none: the largest share
    ({"wind": 0.1, "lost messages": 0.1, "control": 0.1}, (), 2.0, "wind"),  # a storm
    ({"wind": 0.1, "lost messages": 0.1, "control": 0.1}, (), 0.1, "lost messages"),  # gusts of every room
    ({"wind": 0.1, "lost messages": 0.8, "control": 0.1}, (), 0.1, "control"),
    ({"wind": 0.1, "lost messages": 0.1, "control": 0.1}, ("radio_loss",), 2.0, "lost messages"),
    ({"wind": 0.1, "lost messages": 0.8, "control": 0.1}, ("radio_loss",), 2.0, "wind"),
    ({"wind": 0.1, "lost messages": 0.8, "control": 0.1}, ("late",), 2.0, "wind"),
])  # fmt: skip
def test_of_causes_that_only_act_together_the_unusual_one_is_first(
    left: dict[str, float], faults: tuple[str, ...], gusts: float, first: str
) -> None:
    own = library.load("table6")
    struck = tuple(Fault(kind, 1.0, 1.0, (), 0.9) for kind in faults)
    scenario = replace(own, faults=struck, disturbance=replace(own.disturbance, air_std=gusts))
    shares_of = {"wind": 0.4, "lost messages": 0.3, "control": 0.2}
    setup, loss = flight_setup(scenario, BlockChoices("ignoring"), 0), Loss("distance", "cf1", 0, 3.0, 1.0)
    assert first_cause(setup, loss, shares_of, lambda out: left[next(iter(out))], 0.1) == first


def test_a_fault_after_the_loss_or_from_the_start_is_no_event_and_a_flight_may_have_no_cause() -> None:
    loss = Loss("distance", "cf1", 0, 3.0, 1.0)
    for start in (0.0, 3.5):
        scenario = replace(library.load("table6"), faults=(Fault("radio_loss", start, 9.0, (), 0.9),))
        setup = flight_setup(scenario, BlockChoices("ignoring"), 0)
        found = first_cause(setup, loss, {"control": 0.4, "lost messages": 0.3}, lambda _: 0.1, 0.1)
        assert found == "control"
    assert first_cause(setup, loss, {}, lambda _: 1.0, 1.0) is None


def test_no_cause_is_first_that_explains_less_than_the_rest_or_nothing() -> None:
    setup = flight_setup(library.load("table6"), BlockChoices("ignoring"), 0)
    loss = Loss("distance", "cf1", 0, 3.0, 1.0)
    shares_of = {"wind": 0.4, "control": 0.1, "latency": -0.1}
    assert first_cause(setup, loss, shares_of, lambda _: 0.9, 0.6) is None
    assert first_cause(setup, loss, shares_of, lambda _: 0.9, 0.45) == "wind"  # together they explain more
    assert first_cause(setup, loss, shares_of, lambda _: 0.5, 0.6) in {
        "wind",
        "control",
    }  # alone, it takes half
    assert first_cause(setup, loss, {"wind": 0.0, "control": -0.1}, lambda _: 0.1, 0.0) is None
    assert first_cause(setup, replace(loss, size=0.0), shares_of, lambda _: 0.0, 0.0) is None
