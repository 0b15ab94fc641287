"""An explanation splits a loss by its causes, in one sentence."""

from dataclasses import replace

import numpy as np
import pytest
from explained_flights import FOUND, short

from q2q_sim.campaigns.random_runs.random_run import GAINS
from q2q_sim.commands.explain import main
from q2q_sim.experiments.explanation.explanation import CauseShare, ExplanationParams, explain
from q2q_sim.experiments.explanation.explanation_sentence import explanation_sentence
from q2q_sim.experiments.explanation.flight_setup import flight_setup, fly_setup
from q2q_sim.experiments.explanation.loss import LOST, LossKind, largest_loss
from q2q_sim.loop.flight_blocks import BlockChoices
from q2q_sim.scenarios.scenario_document import scenario_from_document


def test_a_loss_is_where_the_vehicle_is_farthest_from_its_setpoint() -> None:
    flight = fly_setup(short("stack3"))
    moved = flight.safe_pos.copy()
    moved[20, 1] = flight.true_pos[20, 1] + (0.0, 0.3, -0.4)
    moved[30, 2] = flight.true_pos[30, 2] + (0.0, 0.0, 0.45)
    moved_flight = replace(flight, safe_pos=moved)
    by_distance, by_height = largest_loss(moved_flight), largest_loss(moved_flight, "height")
    assert (by_distance.row, by_distance.t, by_distance.size) == (1, 0.2, pytest.approx(0.5))
    assert (by_height.row, by_height.t, by_height.size) == (2, pytest.approx(0.3), pytest.approx(0.45))
    moved[40, 0] = np.nan
    assert largest_loss(replace(flight, safe_pos=moved)).size == LOST


def test_the_sentence_reports_loss_causes_rest_and_the_flight_without_the_first() -> None:
    assert explanation_sentence(FOUND) == (
        "cf1 is 83 cm below its setpoint at 3.2 s: 61 cm (55 to 67 cm) by downwash, 10 cm (8.0 to 12 cm) by "
        "latency, 12 cm with none of the causes; flown again with only downwash taken out: 20 cm."
    )
    certain = replace(FOUND, shares=(CauseShare("downwash", 0.61, 0.6101, 0.6102),))
    assert ": 61 cm by downwash, 12 cm with none" in explanation_sentence(certain)
    helped = (*FOUND.shares, CauseShare("wind", -0.05, -0.06, -0.04), CauseShare("control", 0.04, 0.0, 0.08))
    printed = explanation_sentence(replace(FOUND, shares=helped))
    assert "-5.0 cm (-6.0 to -4.0 cm) by wind" in printed
    assert "control" not in printed  # less than a twentieth of the loss


def test_the_sentence_begins_with_the_rest_where_no_cause_explains_the_loss() -> None:
    unexplained = replace(FOUND, shares=(CauseShare("control", -0.05, -0.06, -0.04),), first=None, rest=0.88)
    assert explanation_sentence(unexplained) == (
        "cf1 is 83 cm below its setpoint at 3.2 s; none of the known causes explains it: 88 cm with none of "
        "the causes, -5.0 cm (-6.0 to -4.0 cm) by control."
    )


def test_a_first_cause_whose_interval_holds_0_is_uncertain() -> None:
    doubtful = CauseShare("control", 0.61, -0.2, 1.42), CauseShare("wind", 0.1, -0.2, 0.4)
    printed = explanation_sentence(replace(FOUND, shares=doubtful, first="control"))
    assert "61 cm (-20 to 140 cm, uncertain) by control, 10 cm (-20 to 40 cm) by wind" in printed


@pytest.mark.parametrize(
    ("kind", "size", "outcome"),
    [
        (
            "distance",
            0.125,
            "No vehicle left its path (largest error: cf1 12 cm off its setpoint at 3.2 s): ",
        ),
        ("height", 0.03, "No vehicle lost height (largest error: cf1 3.0 cm below its setpoint at 3.2 s): "),
        ("distance", 0.126, "cf1 is 13 cm off its setpoint at 3.2 s: "),
    ],
)
def test_the_sentence_of_an_ordinary_flight_begins_with_that(
    kind: LossKind, size: float, outcome: str
) -> None:
    found = replace(FOUND, loss=replace(FOUND.loss, kind=kind, size=size))
    assert explanation_sentence(found).startswith(outcome + "61 cm")
    nothing = replace(FOUND, loss=replace(FOUND.loss, kind=kind, size=0.0), first=None)
    assert explanation_sentence(nothing).endswith("its setpoint at 3.2 s).")


def test_a_path_that_no_vehicle_can_fly_has_no_first_cause_and_causes_without_effect_are_omitted() -> None:
    way = [{"t": t, "pos": [x, 0.0, 1.0]} for t, x in ((0.0, 0.0), (1.0, 3.0), (2.0, 3.0))]
    document = {"vehicles": {"cf1": way}, "wake": "measured", "overrides": {"pid": GAINS}}
    setup = flight_setup(scenario_from_document("too fast", document), BlockChoices("ignoring"), 0)
    found = explain(setup, ExplanationParams(orders=4, draws=1))
    assert found.first is None
    assert found.rest == found.without_first == found.loss.size == LOST
    assert found.shares == ()


def test_shares_and_rest_add_up_to_the_loss_and_other_draws_widen_the_intervals() -> None:
    own, both = (explain(short("stack3"), ExplanationParams(orders=4, draws=n)) for n in (1, 2))
    assert sum(one.share for one in own.shares) + own.rest == pytest.approx(own.loss.size, abs=1e-12)
    assert (own.all_orders, own.draws, both.draws) == (False, 1, 2)
    for one, other in zip(own.shares, both.shares, strict=True):
        assert (one.cause, one.share) == (other.cause, other.share)
        assert one.low >= other.low
        assert one.high <= other.high
    assert sum(one.high - one.low for one in own.shares) < sum(one.high - one.low for one in both.shares)


def test_the_help_says_which_orders_are_allowed(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["--help"])
    assert "even, 4 or more (default 8)" in " ".join(capsys.readouterr().out.split())
