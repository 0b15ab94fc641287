"""Tests of what identification says about its models: roles, scores on other flights, choice, remarks."""

from dataclasses import replace

import numpy as np
import pytest
from identification_passes import FLOWN, eta_error, identification_data, records
from made_flights import LOOP, Pass, made_flight
from resting_signals import resting_state

from q2q_model.downwash.jet import MEASURED_LAW, PAPER_LAW, Jet
from q2q_model.downwash.level_set import peak_downwash
from q2q_model.downwash.no_interaction import NoInteraction
from q2q_model.downwash.predictor import InteractionPredictor
from q2q_model.flights.flight import of_vehicle
from q2q_model.identification.gains.altitude_from_flight import altitude_record
from q2q_model.identification.gains.altitude_record import AltitudeRecord
from q2q_model.identification.identification import ProcedureParams, identify
from q2q_model.identification.push.along_flight import Motion, eta_along
from q2q_model.identification.selection.candidates_of_kind import candidates
from q2q_model.identification.selection.cross_validation import score_held_out, score_on
from q2q_model.identification.selection.identification_data import (
    IdentificationData,
    has_exposure,
    is_lower,
    largest_gap,
)
from q2q_model.identification.selection.model_choice import best_trial, score_candidates
from q2q_model.identification.selection.model_doubts import Scores, model_doubts
from q2q_model.identification.statistics.intervals import Interval
from q2q_model.model_files.model_file import RoleScores
from q2q_model.recordings.flight_recording import Recording
from q2q_model.signals.values import SwarmState
from q2q_model.tools.identify_report import summary
from q2q_model.vehicle.altitude_loop import AltitudeLoop
from q2q_model.vehicle.constants import CRAZYFLIE_2_0

VEHICLE = replace(CRAZYFLIE_2_0, thrust_lag=LOOP.lag)
"""The one that made the flights."""


def test_a_model_along_a_flight_is_the_online_predictors_answer():
    record = records()[1]
    motion = Motion(record.t, record.pos, record.vel, record.axis)
    law = replace(MEASURED_LAW, carried=1.0)
    predictor, whole = InteractionPredictor(law), eta_along(law, motion)
    answers = [predictor.update(_state(record, k)).acc for k in range(record.t.size)]
    np.testing.assert_allclose(np.stack(answers), whole, atol=1e-9)


def _state(record: AltitudeRecord, k: int) -> SwarmState:
    return resting_state(float(record.t[k]), record.names, record.pos[k], vel=record.vel[k])


def test_roles_are_read_from_who_flies_below():
    assert is_lower(records()[0]) == [True, False]


@pytest.mark.filterwarnings("error")
def test_a_vehicle_that_flies_alone_is_below_nobody():
    alone = of_vehicle(made_flight(FLOWN[0]), "cf1")
    assert is_lower(altitude_record(alone, CRAZYFLIE_2_0)) == [False]


def test_scores_are_one_for_the_law_that_flew_and_zero_for_none():
    truth, nothing = (score_on(law, identification_data(), LOOP) for law in (PAPER_LAW, NoInteraction()))
    assert truth.r2.lower == pytest.approx(1.0, abs=0.02)  # noise of 5 mm/s^2 on pushes of 0.4 m/s^2
    assert nothing.r2.lower == pytest.approx(0.0, abs=1e-12)
    assert truth.mse_m2.lower is not None
    assert nothing.mse_m2.lower is not None
    assert truth.mse_m2.lower < 0.05 * nothing.mse_m2.lower


def test_a_score_says_whether_it_is_of_downwash_or_of_altitude():
    """Without measured pushes R2 is the share of the altitudes' mean square that downwash explains."""
    poses_only = [replace(one, pushes=()) for one in identification_data()]
    truth, none = (score_on(model, poses_only, LOOP) for model in (PAPER_LAW, NoInteraction()))
    assert truth.r2_of == "altitude deviation"
    assert score_on(PAPER_LAW, identification_data(), LOOP).r2_of == "downwash"
    assert truth.mse_m2.lower is not None
    assert none.mse_m2.lower is not None
    assert truth.r2.lower == pytest.approx(1.0 - truth.mse_m2.lower / none.mse_m2.lower, abs=1e-12)


def test_held_out_flights_are_scored_by_a_model_that_has_not_seen_them():
    seen: list[set[str]] = []

    def fit(flights: list[IdentificationData]) -> NoInteraction:
        seen.append({one.name for one in flights})
        return NoInteraction()

    score_held_out(fit, identification_data(), LOOP)  # type: ignore[arg-type]
    names = {one.name for one in FLOWN}
    assert seen == [names - {one.name} for one in FLOWN]


def test_with_one_flight_nothing_is_claimed_about_others():
    assert score_held_out(lambda _: PAPER_LAW, identification_data()[:1], LOOP).r2.lower is None


def test_the_plain_jet_is_kept_where_freedom_brings_nothing():
    flights = identification_data()
    tried = candidates("jet", flights, LOOP)
    best = best_trial(score_candidates(tried, flights, LOOP, lambda _: None)[0])
    assert best.candidate.name == "jet, straight down, power law"


def test_an_unknown_kind_of_model_is_refused():
    with pytest.raises(ValueError, match="unknown model type 'tree': choose one of auto, jet"):
        candidates("tree", [], LOOP)


def test_identify_goes_from_flights_to_a_model_that_holds():
    steps: list[str] = []
    recordings = [Recording(made_flight(one)) for one in FLOWN]
    found = identify(recordings, ProcedureParams(model_type="jet", vehicle=VEHICLE), steps.append)
    assert found.gains.k_p.value == pytest.approx(LOOP.k_p, rel=0.05)
    assert found.file.gains is not None
    assert found.file.gains.lag == LOOP.lag
    assert eta_error(found.file.interaction, FLOWN[2]) < 0.10
    assert found.zone is not None
    assert found.zone.d == pytest.approx(0.83 * np.sqrt(0.392 / 0.1) - 0.33, rel=0.1)
    (extent,) = (one for one in found.remarks if one.startswith("zone from the downwash"))
    assert f"d = {found.zone.d:.2f} m lies beyond the largest gap flown, 0.8" in extent  # 0.7 m, and the push
    assert steps[0] == "records"
    assert steps[-1] == "final fit"
    assert f"R2 {found.held_out.r2.lower:.3f} of the lower vehicle's downwash\n" in summary(found)


def test_the_largest_gap_flown_is_one_beyond_the_scoring_rule_too():
    low, high = (
        altitude_record(made_flight(Pass(gap=gap, law=NoInteraction(), seconds=20.0)), CRAZYFLIE_2_0)
        for gap in (0.6, 1.9)
    )
    assert largest_gap([low]) == pytest.approx(0.6, abs=1e-6)
    assert largest_gap([low, high]) == pytest.approx(1.9, abs=1e-6)
    assert [has_exposure(one) for one in (low, high)] == [True, False]
    aside = replace(high, pos=high.pos + np.array([[0.0, 0.0, 0.0], [0.2, 0.0, 0.0]]))
    assert largest_gap([aside]) == 0.0


def test_commands_that_answer_gusts_do_not_move_the_thrust_lag():
    """The lag that fits such flights best is 0.16 s, and a jet that is fitted with it is 10 % too weak."""
    loop = AltitudeLoop(10.0, 5.0, lag=CRAZYFLIE_2_0.thrust_lag)
    flights = [replace(one, loop=loop, gust=0.1) for one in FLOWN]
    recordings = [Recording(made_flight(one)) for one in flights]
    found = identify(recordings, ProcedureParams(model_type="jet"), lambda _: None)
    assert found.file.gains is not None
    assert found.file.gains.lag == CRAZYFLIE_2_0.thrust_lag
    (message,) = (one for one in found.remarks if "thrust lag" in one)
    assert message == f"push of {len(flights)} flights is from imu and command, with a thrust lag of 0.07 s"


def test_a_zone_that_ends_at_the_models_range_is_reported():
    recordings = [Recording(made_flight(one)) for one in FLOWN]
    params = ProcedureParams(model_type="jet", threshold=0.02)
    found = identify(recordings, params, lambda _: None)
    assert found.zone is not None
    assert found.zone.d == pytest.approx(1.5, abs=0.011)  # the jet's range, to a grid step
    (extent,) = (one for one in found.remarks if one.startswith("zone from the downwash"))
    assert "is the range of the model, where its downwash still exceeds 0.02 m/s^2, and lies" in extent


def test_flights_without_commands_still_give_a_model_and_a_remark():
    flights = (Pass(name="calm", law=NoInteraction(), start=0.3), FLOWN[0])
    blind = [replace(made_flight(one), thrust=np.full((3000, 2), np.nan)) for one in flights]
    params = ProcedureParams(model_type="envelope_network")
    found = identify([Recording(one) for one in blind], params, lambda _: None)
    assert any("gains are from trajectories" in remark for remark in found.remarks)
    assert not any(one.pushes for one in found.data)
    assert f"R2 {found.held_out.r2.lower:.3f} of the lower vehicle's altitude deviation\n" in summary(found)
    assert found.file.fit is not None
    assert found.file.fit.train_mse_m2.lower is not None
    assert found.file.fit.train_mse_m2.lower < 1.13e-3  # the paper's, section 3.2


def test_a_model_that_its_flights_do_not_show_is_doubted():
    """Gains without intervals above 0, or held-out errors as large as those of no model, are said."""
    recordings = [Recording(made_flight(one)) for one in FLOWN]
    found = identify(recordings, ProcedureParams(model_type="jet"), lambda _: None)
    law, spread = found.file.interaction, dict(found.spread)
    scores = Scores(found.train, found.held_out)
    assert model_doubts(found.gains, scores, found.data, law, spread) == []
    assert model_doubts(found.gains, scores, found.data[:1], NoInteraction(), {}) == []
    unknown = replace(found.gains, k_d=Interval(0.4, 0.0, 0.9))
    inferred = [replace(one, pushes=()) for one in found.data]
    (first,) = model_doubts(unknown, scores, inferred, law, spread)
    assert first.startswith("the downwash is inferred with gains that these flights do not determine")
    useless = replace(scores, held_out=replace(found.held_out, r2=RoleScores(lower=-0.01)))
    (second,) = model_doubts(found.gains, useless, found.data, law, spread)
    assert "no better than none (R2 -0.010)" in second
    assert isinstance(law, Jet)
    lifting = replace(law, strength=-law.strength)
    (third,) = model_doubts(found.gains, scores, found.data, lifting, spread)
    assert third.startswith("the model lifts vehicles that are under others")
    either = spread | {"strength": Interval(1.0, -5.0, 15.0)}
    unseen = replace(scores, train=replace(found.train, r2=RoleScores(lower=0.07)))
    (fourth,) = model_doubts(found.gains, unseen, found.data, law, either)
    assert "do not show downwash (strength 1 m/s^2 [-5, 15]): do not compensate" in fourth
    (unsure,) = model_doubts(found.gains, scores, found.data, law, either)
    assert unsure == "these flights do not determine strength: the interval is the range of the search"
    wide = spread | {"width": Interval(0.1, 0.015, 0.4)}
    (fifth,) = model_doubts(found.gains, scores, found.data, law, wide)
    assert fifth == "these flights do not determine width: the interval is the range of the search"
    signless = spread | {"strength": Interval(1.0, -0.2, 2.2)}
    (seventh,) = model_doubts(found.gains, scores, found.data, law, signless)
    assert seventh == "these flights do not determine strength: its interval [-0.2, 2.2] m/s^2 contains 0"
    (sixth,) = model_doubts(found.gains, scores, found.data[:1], law, spread)
    assert sixth.startswith("no flight was left out")


@pytest.mark.parametrize("apart", [0.0, 2.0])
def test_where_no_wake_was_flown_the_model_claims_none(apart: float):
    """Passes in air without downwash, over each other and side by side."""
    flights = []
    for number, gap in enumerate((0.4, 0.6)):
        made = made_flight(Pass(f"calm {number}", gap=gap, seconds=20.0, law=NoInteraction(), noise=4e-3))
        aside = np.array([[0.0, 0.0, 0.0], [0.0, apart, 0.0]])
        moved = {name: getattr(made, name) + aside for name in ("pos", "mocap_pos", "true_pos", "ref_pos")}
        flights.append(Recording(replace(made, **moved)))
    found = identify(flights, ProcedureParams(model_type="jet"), lambda _: None)
    assert peak_downwash(found.file.interaction) <= 0.05
    assert found.chosen.kind == "none"
