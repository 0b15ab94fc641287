"""Tests of the scoring rule on rows made by hand and on real flights."""

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from made_flights import Pass, made_flight

from q2q_model.downwash.jet import MEASURED_LAW, Jet
from q2q_model.downwash.no_interaction import NoInteraction
from q2q_model.flights.first_order_lag import first_order_lag
from q2q_model.flights.flight_log import FlightLog
from q2q_model.geometry.rotations import rotate
from q2q_model.identification.push.along_flight import Motion, eta_along, eta_on_vehicle
from q2q_model.identification.push.held_out_deviation import with_held_out_deviation
from q2q_model.identification.push.jet_fit import fit_to_pushes
from q2q_model.identification.push.jet_form import JetForm
from q2q_model.identification.push.push_samples import (
    PushRecord,
    PushSamples,
    known_rows,
    pooled_score,
    push_samples,
    score,
    unmeasured_note,
)
from q2q_model.identification.push.recorded_push import LOG_MASS, check_weight, motion_of, push_of_log
from q2q_model.signals.values import Array, Mask
from q2q_model.vehicle.constants import CRAZYFLIE_2_0, CRAZYFLIE_2_1, TEXTBOOK_065

DATA = Path(os.environ.get("Q2Q_DATA", "../shared/data")) / "neural_swarm"
needs_flights = pytest.mark.skipif(not DATA.is_dir(), reason=f"no recorded flights in {DATA}: set Q2Q_DATA")
OFF, ON = "dc19", "dc21"
"""Families: feed-forward off, on. Never pooled."""


def record(rel: Array, push: Array, height: float = 1.0) -> PushRecord:
    """Return a record in which vehicle 0 hovers and vehicle 1 is at `rel` (T, 3) from it."""
    ticks = rel.shape[0]
    pos = np.zeros((ticks, 2, 3))
    pos[:, 0, 2] = height
    pos[:, 1] = pos[:, 0] + rel
    up = np.tile([0.0, 0.0, 1.0], (ticks, 2, 1))
    motion = Motion(0.01 * np.arange(ticks), pos, np.zeros_like(pos), up)
    good = np.ones((ticks, 2), dtype=bool)
    return PushRecord("made", ("a", "b"), motion, np.stack([push, 0.0 * push], axis=1), good, ~good)


def passing(ticks: int = 1000) -> Array:
    """Return a source half a metre above that passes from -1 m to 1 m."""
    return np.stack([np.zeros(ticks), np.linspace(-1.0, 1.0, ticks), np.full(ticks, 0.5)], axis=1)


def lower_of(made: PushRecord) -> PushSamples:
    """Return the samples of vehicle 0."""
    return next(one for one in push_samples(made) if one.vehicle == 0)


def test_commands_that_do_not_carry_the_vehicle_are_refused_with_the_remedy():
    flight = made_flight(Pass())
    check_weight(flight, CRAZYFLIE_2_0)
    check_weight(flight, CRAZYFLIE_2_1)  # 27 g, not 34
    check_weight(
        replace(flight, thrust=np.full_like(flight.thrust, np.nan)), TEXTBOOK_065
    )  # nothing to judge
    waits = np.where(flight.t[:, None] < 20.0, 0.0, 1.0)  # two thirds of the flight on the ground
    pos = flight.pos * waits[..., None]
    check_weight(replace(flight, pos=pos, thrust=flight.thrust * waits), CRAZYFLIE_2_0)
    with pytest.raises(ValueError, match=r"0\.0523 times the weight of textbook_065.*with --vehicle"):
        check_weight(flight, TEXTBOOK_065)
    pwm = replace(flight, thrust=flight.thrust / CRAZYFLIE_2_0.full_pwm_thrust * 65535.0)
    with pytest.raises(
        ValueError, match=r"flight pass: the median thrust of cf1 .*record commands in newtons"
    ):
        check_weight(pwm, CRAZYFLIE_2_0)


def test_exposed_free_and_upper_rows_are_those_of_the_rule():
    rel = passing()
    lower = lower_of(record(rel, np.zeros(1000)))
    np.testing.assert_array_equal(lower.exposed, np.abs(rel[:, 1]) < 0.15)
    upper = next(one for one in push_samples(record(rel, np.zeros(1000))) if one.vehicle == 1)
    assert not upper.exposed.any()
    np.testing.assert_array_equal(upper.upper, np.abs(rel[:, 1]) < 0.1)
    assert not lower.upper.any()


def test_a_constant_of_the_vehicle_is_taken_off_by_its_free_rows():
    rel = passing()
    push = np.where(np.abs(rel[:, 1]) < 0.15, -2.0, 0.0) + 0.7
    y = lower_of(record(rel, push)).y
    np.testing.assert_allclose(y[np.abs(rel[:, 1]) > 0.3], 0.0, atol=1e-12)
    np.testing.assert_allclose(y[np.abs(rel[:, 1]) < 0.1], -2.0, atol=1e-12)


def test_rows_that_are_low_mended_or_saturated_do_not_count():
    made = record(passing(), np.zeros(1000))
    low = push_samples(record(passing(), np.zeros(1000), height=0.2))
    assert [one.vehicle for one in low] == [1]  # the other has no usable row at all
    measured, saturated = made.measured.copy(), made.saturated.copy()
    measured[480:490, 1] = False  # of the neighbour: its place is not known either
    saturated[510:520, 0] = True
    lower = lower_of(replace(made, measured=measured, saturated=saturated))
    assert not lower.usable[480:490].any()
    assert not lower.usable[510:520].any()
    assert lower.usable.sum() == 980


def test_a_vehicle_with_too_few_free_rows_is_not_scored():
    always_above = np.tile([0.0, 0.0, 0.5], (1000, 1))
    assert [one.vehicle for one in push_samples(record(always_above, np.zeros(1000)))] == [1]


def test_r2_is_one_for_the_law_that_pushed_and_zero_for_none():
    rel = passing()
    made = record(rel, np.zeros(1000))
    push = eta_along(MEASURED_LAW, made.motion)[:, 0, 2]
    samples = [lower_of(record(rel, push))]
    assert score(MEASURED_LAW, samples).r2_exposed == pytest.approx(1.0, abs=1e-12)
    assert score(MEASURED_LAW, samples).r2_ahead_20ms == pytest.approx(1.0, abs=1e-12)
    assert score(NoInteraction(), samples).r2_exposed == 0.0
    assert score(MEASURED_LAW, samples).n == int((np.abs(rel[:, 1]) < 0.15).sum())


def test_a_vehicle_that_is_away_spoils_no_row_of_others():
    made = record(passing(), np.zeros(1000))
    third = np.zeros((1000, 1, 3))
    third[:, :, 0] = 3.0
    third[600:, :, 0] = 0.4  # comes within half a metre of vehicle 0
    motion = replace(
        made.motion,
        pos=np.concatenate([made.motion.pos, third], axis=1),
        vel=np.zeros((1000, 3, 3)),
        axis=np.tile([0.0, 0.0, 1.0], (1000, 3, 1)),
    )
    unseen = np.zeros((1000, 1), dtype=bool)
    unseen[400:500] = True  # one second without a measurement before, none of two
    joined = replace(
        made,
        names=("a", "b", "c"),
        motion=motion,
        push=np.zeros((1000, 3)),
        measured=np.concatenate([made.measured, unseen], axis=1),
        saturated=np.zeros((1000, 3), dtype=bool),
    )
    np.testing.assert_array_equal(known_rows(joined)[:, 0], np.arange(1000) < 600)
    assert known_rows(joined)[400:500, 2].all()
    assert known_rows(joined)[:, 2].sum() == 100
    brief = joined.measured.copy()
    brief[:, 2] = True
    brief[100:250, 2] = False  # 1.5 s: a gap, in which it may be anywhere
    gap = known_rows(replace(joined, measured=brief))
    np.testing.assert_array_equal(gap[:, 0], brief[:, 2])
    assert unmeasured_note(joined) == ""
    never = replace(joined, measured=np.concatenate([made.measured, np.zeros((1000, 1), dtype=bool)], axis=1))
    assert unmeasured_note(never) == "made: nothing was measured of c"
    assert push_samples(never)[0].usable.sum() == 600


def test_motors_logged_as_pwm_saturate_where_those_logged_as_duty_do():
    flight = made_flight(Pass())
    columns = ("faz_est", "gap", "pwm1", "pwm2", "pwm3", "pwm4")
    values = np.full((flight.t.size, 2, 6), 0.5)
    values[..., 1] = 0.0
    values[100:120, 0, 4] = 0.95
    found = []
    for full in (1.0, 65535.0):
        scaled = values * np.array([1.0, 1.0, full, full, full, full])
        log = FlightLog(flight.t, flight.names, columns, ("",) * 6, scaled)
        found.append(push_of_log("made", log, motion_of(flight), LOG_MASS).saturated)
    assert np.flatnonzero(found[0][:, 0]).tolist() == list(range(100, 120))
    assert not found[0][:, 1].any()
    np.testing.assert_array_equal(*found)


def test_without_exposed_rows_nothing_is_claimed():
    far = np.tile([2.0, 0.0, 0.5], (1000, 1))
    found = score(MEASURED_LAW, push_samples(record(far, np.zeros(1000))))
    assert found.r2_exposed is None
    assert found.n == 0
    assert score(MEASURED_LAW, []).mean_upper_mps2 is None


def test_the_lag_is_a_first_order_and_missing_commands_repeat_the_last():
    t = 0.01 * np.arange(300)
    step = np.where(t < 1.0, 0.0, 1.0)[:, None]
    answer = first_order_lag(step, t, 0.1)
    assert answer[150, 0] == pytest.approx(1.0 - np.exp(-0.51 / 0.1), rel=1e-9)  # 51 ticks after the step
    np.testing.assert_array_equal(first_order_lag(step, t, 0.0), step)


def test_the_lag_of_frames_that_come_at_uneven_times_is_that_of_their_own_steps():
    """A third of the frames is lost; the command steps at 1 s, and each frame shows the step's answer."""
    t = 0.01 * np.arange(300)[np.random.default_rng(6).random(300) > 0.3]
    step = np.where(t < 1.0, 0.0, 1.0)[:, None]
    before = t[t < 1.0][-1]
    expected = np.where(t < 1.0, 0.0, 1.0 - np.exp(-(t - before) / 0.1))
    np.testing.assert_allclose(first_order_lag(step, t, 0.1)[:, 0], expected, atol=1e-12)


def real_samples(family: str) -> dict[str, list[PushSamples]]:
    """Return the samples of all flights of a family with more than one vehicle."""
    found = {path.stem: push_samples(_real(path)) for path in sorted(DATA.glob(f"{family}*_ss*.parquet"))}
    return {name: samples for name, samples in found.items() if samples}


def _real(path: Path) -> PushRecord:
    from pyarrow import parquet

    table = parquet.read_table(path)
    names = tuple(sorted({name[:4] for name in table.column_names if name.startswith("cf")}))

    def columns(*expected: str) -> Array:
        return np.array(
            [[table[f"{name}_{one}"].to_numpy() for one in expected] for name in names], dtype=float
        )

    t = np.asarray(table["t"].to_numpy(), dtype=float)
    expected = (("x", "y", "z"), ("vx", "vy", "vz"), ("qx", "qy", "qz", "qw"))
    pos, vel, quat = (columns(*some).transpose(2, 0, 1) for some in expected)
    logged = ("faz_est", "gap", "pwm1", "pwm2", "pwm3", "pwm4")
    log = FlightLog(t, names, logged, ("",) * 6, columns(*logged).transpose(2, 0, 1))
    motion = Motion(t, pos, vel, rotate(quat, np.array([0.0, 0.0, 1.0])))
    return push_of_log(path.stem, log, motion, LOG_MASS)


def held_out(family: str, form: JetForm) -> tuple[float, float]:
    """Return R2 on flights left out of the fit one after the other, and the mean push on upper vehicles."""
    flights = real_samples(family)
    y, misses = [], []
    for name, samples in flights.items():
        others = [one for other, found in flights.items() if other != name for one in found]
        jet = fit_to_pushes(others, form).jet
        for one in samples:
            if one.exposed.any():
                eta = eta_along(jet, one.motion)[one.exposed, one.vehicle, 2]
                y.append(one.y[one.exposed])
                misses.append(y[-1] - eta)
    found = pooled_score(y, misses, [one for samples in flights.values() for one in samples])
    assert found.r2_exposed is not None
    assert found.mean_upper_mps2 is not None
    return found.r2_exposed, found.mean_upper_mps2


def test_vehicles_that_feel_nothing_at_all_leave_r2_undefined() -> None:
    """As in a simulator without noise and downwash: R2 would divide by the square of what was felt."""
    found = score(NoInteraction(), push_samples(record(passing(), np.zeros(1000))))
    assert found.n > 0
    assert (found.r2_exposed, found.r2_ahead_20ms, found.rmse_exposed_mps2) == (None, None, 0.0)


@needs_flights
def test_a_jet_predicts_real_flights_it_has_not_seen_feed_forward_off():
    r2, upper = held_out(OFF, JetForm())
    assert r2 >= 0.86  # issue 3 asks for 0.84; 0.865 found
    assert abs(upper) < 0.1  # no effect on the upper vehicle


@needs_flights
def test_what_moves_matters_on_real_flights():
    """The same jet that falls straight down explains less: the source's slope and speed are no ornament."""
    moving, straight = (held_out(OFF, JetForm(carried=carried))[0] for carried in (1.0, 0.0))
    assert 1.0 - moving < 0.8 * (1.0 - straight)


@pytest.fixture(scope="module")
def below() -> list[PushSamples]:
    """Return what the lower vehicles of the flights without feed-forward felt."""
    return [one for found in real_samples(OFF).values() for one in found if one.exposed.any()]


@pytest.fixture(scope="module")
def jet_of_them(below: list[PushSamples]) -> Jet:
    """Return the jet fitted to these very samples."""
    return fit_to_pushes(below, JetForm()).jet


@needs_flights
@pytest.mark.parametrize("seconds", [7.3, 10.0, 13.7, 23.1])
def test_with_a_neighbours_log_rolled_the_gain_vanishes(
    below: list[PushSamples], jet_of_them: Jet, seconds: float
):
    """The same rows, those exposed to the true neighbour; the law is fed with the neighbour of another time.

    R2 of the scoring rule is not centred: on these rows somebody is above, by about 2 m/s^2 on average, and a
    constant explains 0.60. In half of them the rolled neighbour is above too, for these flights pass and pass
    again, which leaves 0.03 to 0.21 of R2 at any roll. The gain is what a law explains beyond the constant:
    0.75 with the true neighbour, below -0.9 with the rolled one. Over all usable rows R2 itself is negative.
    """
    rolled = [_rolled(one, seconds) for one in below]
    assert _beyond_constant(jet_of_them, below) > 0.7
    assert _beyond_constant(jet_of_them, rolled) < -0.5
    assert _explained(jet_of_them, rolled, "exposed") < 0.3
    assert _explained(jet_of_them, below, "usable") > 0.75
    assert _explained(jet_of_them, rolled, "usable") < -0.4


@needs_flights
@pytest.mark.parametrize("seconds", [7.3, 10.0])
def test_a_law_fitted_to_a_rolled_neighbour_explains_less_than_a_constant(
    below: list[PushSamples], seconds: float
):
    """Refitted, the jet becomes as wide as it may, a constant for whoever is exposed, and stays below it."""
    rolled = [_rolled(one, seconds) for one in below]
    jet = fit_to_pushes(rolled, JetForm()).jet
    assert jet.width > 0.3  # that of the true neighbour: 0.05
    assert _beyond_constant(jet, rolled) < 0.0
    assert _explained(jet, rolled, "usable") < 0.0


def _explained(jet: Jet, samples: list[PushSamples], rows: str) -> float:
    y, eta = _measured_and_predicted(jet, samples, rows)
    return float(1.0 - ((y - eta) @ (y - eta)) / (y @ y))


def _beyond_constant(jet: Jet, samples: list[PushSamples]) -> float:
    """Return 1 - sum (y - eta)^2 / sum (y - mean y)^2 over exposed rows."""
    y, eta = _measured_and_predicted(jet, samples, "exposed")
    return float(1.0 - ((y - eta) @ (y - eta)) / ((y - y.mean()) @ (y - y.mean())))


def _measured_and_predicted(jet: Jet, samples: list[PushSamples], rows: str) -> tuple[Array, Array]:
    chosen = [np.nonzero({"exposed": one.exposed, "usable": one.usable}[rows])[0] for one in samples]
    eta = [
        eta_on_vehicle(jet, one.motion, one.vehicle, at)[:, 2]
        for one, at in zip(samples, chosen, strict=True)
    ]
    return np.concatenate([one.y[at] for one, at in zip(samples, chosen, strict=True)]), np.concatenate(eta)


def _rolled(one: PushSamples, seconds: float) -> PushSamples:
    """Return the samples with everyone but the vehicle itself so much late; rows stay as they were chosen."""
    motion = one.motion
    pos, vel, axis = (values.copy() for values in (motion.pos, motion.vel, motion.axis))
    others = [j for j in range(pos.shape[1]) if j != one.vehicle]
    for values in (pos, vel, axis):
        values[:, others] = np.roll(values[:, others], round(seconds * 100.0), axis=0)
    return replace(one, motion=replace(motion, pos=pos, vel=vel, axis=axis))


@needs_flights
def test_feed_forward_on_is_predicted_too():
    """Four flights of the family, two and three vehicles; the whole family takes minutes and gives 0.863."""
    flights = {name: found for name, found in real_samples(ON).items() if name.startswith("dc21_swap_s")}
    names = list(flights)
    chosen = names[::2]
    training = [one for name in names if name not in chosen for one in flights[name]]
    jet = with_held_out_deviation(fit_to_pushes(training, JetForm()).jet, training, JetForm())
    found = score(jet, [one for name in chosen for one in flights[name]])
    assert found.r2_exposed is not None
    assert found.r2_exposed >= 0.80
    assert found.r2_ahead_20ms is not None
    assert found.r2_ahead_20ms >= 0.93
    assert LOG_MASS == 0.032
    within = [_within_band(jet, one) for name in chosen for one in flights[name] if one.exposed.any()]
    assert 0.93 <= np.concatenate(within).mean() <= 0.97  # of 95 %: 0.944 over the whole family


@needs_flights
def test_the_deviation_that_one_flight_teaches_holds_on_the_other_flight_feed_forward_off():
    """One flight cannot show how flights differ; its halves show the doubt of a fit to half as much."""
    flights = list(real_samples(OFF).values())
    within = []
    for training, other in zip(flights, reversed(flights), strict=True):
        jet = with_held_out_deviation(fit_to_pushes(training, JetForm()).jet, training, JetForm())
        within += [_within_band(jet, one) for one in other if one.exposed.any()]
    assert len(flights) == 2
    assert 0.93 <= np.concatenate(within).mean() <= 0.97  # of 95 %: 0.931; by its own misses 0.909


def _within_band(jet: Jet, one: PushSamples) -> Mask:
    """Return which exposed rows lie within 1.96 of the deviations that the model claims."""
    rows = np.nonzero(one.exposed)[0]
    eta = eta_on_vehicle(jet, one.motion, one.vehicle, rows)[:, 2]
    return np.abs(one.y[rows] - eta) <= 1.96 * (jet.std_floor + jet.relative_std * np.abs(eta))
