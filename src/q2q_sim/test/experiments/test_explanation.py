"""An explanation splits a loss by its causes, in one sentence."""

from dataclasses import replace

import numpy as np
import pytest
from explained_flights import FOUND, short

from q2q_sim.commands.explain import main
from q2q_sim.experiments.explanation.explanation import CauseShare, ExplanationParams, explain
from q2q_sim.experiments.explanation.explanation_sentence import explanation_sentence
from q2q_sim.experiments.explanation.flight_setup import fly_setup
from q2q_sim.experiments.explanation.loss import LOST, largest_loss


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
    assert explanation_sentence(replace(FOUND, shares=())).endswith("; none of the known causes explains it.")
    helped = (*FOUND.shares, CauseShare("wind", -0.05, -0.06, -0.04), CauseShare("control", 0.04, 0.0, 0.08))
    printed = explanation_sentence(replace(FOUND, shares=helped))
    assert "-5.0 cm (-6.0 to -4.0 cm) by wind" in printed
    assert "control" not in printed  # less than a twentieth of the loss


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
