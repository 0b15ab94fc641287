"""Tests of the fit of the residual process, and the correction of predictions by measured pushes."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from resting_signals import level_command, resting_state
from scipy.signal import lfilter

from q2q_model.downwash.correction.corrected_predictor import CorrectedPredictor, ResidualCorrector
from q2q_model.downwash.correction.measured_push import LONGEST_STEP, MeasuredPush
from q2q_model.downwash.correction.residual_process import OLDEST, ResidualProcess
from q2q_model.downwash.jet import Jet
from q2q_model.downwash.predictor import InteractionPredictor
from q2q_model.identification.jet.jet_deviation import deviation_of
from q2q_model.identification.jet.residual_fit import fit_residual
from q2q_model.identification.push.along_flight import Motion, eta_along
from q2q_model.identification.push.push_samples import PushRecord, PushSamples, push_samples
from q2q_model.model_files.model_file import ModelFile, decode, encode
from q2q_model.signals.values import (
    Array,
    Interference,
    InterferenceStatus,
    Names,
    SwarmImu,
)
from q2q_model.vehicle.constants import CRAZYFLIE_2_1, GRAVITY

PROCESS = ResidualProcess(floor=0.3, slope=0.15, time_s=0.1, noise=0.15)
LAW = Jet(strength=2.5, reference_gap=0.4, width=0.08, upper_ratio=0.0)
STEP = 0.01
NAMES = ("low", "top")


def unit_process(rng: np.random.Generator, ticks: int, step: float = STEP) -> Array:
    """Return an Ornstein-Uhlenbeck process of variance 1, (ticks,)."""
    keep = PROCESS.correlation(step)
    return np.asarray(lfilter([np.sqrt(1.0 - keep**2)], [1.0, -keep], rng.standard_normal(ticks)))


def flown(
    seed: int,
    step: float = STEP,
    sway: float = 0.5,
    noise: float = PROCESS.noise,
    process: ResidualProcess = PROCESS,
) -> list[PushSamples]:
    """Return 6000 pushes of a vehicle under another that passes to and fro, with residual and noise."""
    rng, t = np.random.default_rng(seed), step * np.arange(6000)
    pos = np.zeros((t.size, 2, 3))
    pos[:, :, 2] = [1.0, 1.5]
    pos[:, 1, 0] = sway * np.sin(0.9 * t)
    motion = Motion(t, pos, np.gradient(pos, step, axis=0), np.tile([0.0, 0.0, 1.0], (t.size, 2, 1)))
    push = eta_along(LAW, motion)[..., 2]
    push[:, 0] += process.std(push[:, 0]) * unit_process(rng, t.size, step)
    push += noise * rng.standard_normal(push.shape)
    good = np.ones(push.shape, dtype=bool)
    record = PushRecord(f"flight{seed}", NAMES, motion, push, good, ~good)
    return [one for one in push_samples(record) if one.vehicle == 0]


def test_the_fit_finds_the_process_that_residuals_were_made_with() -> None:
    found = fit_residual(LAW, [one for seed in range(6) for one in flown(seed)])
    assert found is not None
    for name, span in found.intervals:
        assert span is not None
        truth = getattr(PROCESS, name)
        deviation = (span.high - span.value) / 2.5706  # t of five, 97.5 %
        assert abs(span.value - truth) < 4.0 * deviation, name
        assert deviation < 0.8 * truth, name  # noise, the least of them, hides below the process


def test_noise_of_the_measurement_changes_neither_floor_nor_slope() -> None:
    quiet, noisy = (
        fit_residual(LAW, [one for seed in range(12) for one in flown(seed, sway=0.32, noise=noise)])
        for noise in (0.05, 0.5)
    )
    assert quiet is not None
    assert noisy is not None
    # in three series of 12 flights by at most 0.035 and 0.02; as part of the deviation by 0.09 and 0.05
    assert noisy.process.floor == pytest.approx(quiet.process.floor, abs=0.05)
    assert noisy.process.slope == pytest.approx(quiet.process.slope, abs=0.03)
    assert noisy.process.noise == pytest.approx(0.5, rel=0.05)


def test_beside_a_noise_as_large_as_the_process_the_fit_has_settled() -> None:
    """Beside the noise found, the deviation of maximum likelihood has the same floor over slope."""
    small = replace(PROCESS, floor=0.02, slope=0.2)
    samples = [one for seed in range(8) for one in flown(seed, noise=0.5, process=small)]
    found = fit_residual(LAW, samples)
    assert found is not None
    push = np.concatenate([eta_along(LAW, one.motion)[one.exposed, 0, 2] for one in samples])
    residual = np.concatenate([one.y[one.exposed] for one in samples]) - push
    floor, slope = deviation_of(np.abs(push), np.abs(residual), found.process.noise)
    # a third fit leaves 3 %, a second one 20 %
    assert found.process.floor / found.process.slope == pytest.approx(floor / slope, rel=0.05)


@pytest.mark.parametrize("rates", [(50.0,), (33.0,), (20.0,), (100.0, 20.0)])
def test_slow_and_mixed_rates_find_the_same_process(rates: tuple[float, ...]) -> None:
    """At 20 Hz no lag is shorter than 50 ms; one of 0 would take the noise for residual."""
    steps = [1.0 / rates[seed % len(rates)] for seed in range(6)]
    found = fit_residual(LAW, [one for seed in range(6) for one in flown(seed, steps[seed], sway=0.32)])
    assert found is not None
    assert found.process.time_s == pytest.approx(PROCESS.time_s, rel=0.2)  # two deviations, of 6 flights
    assert found.process.noise == pytest.approx(PROCESS.noise, rel=0.3)


def test_a_rate_with_two_short_lags_shows_no_process() -> None:
    assert fit_residual(LAW, [one for seed in range(6) for one in flown(seed, 0.1)]) is None


def test_few_flights_give_the_wider_intervals_of_students_t() -> None:
    samples = [one for seed in range(4) for one in flown(seed)]
    found = fit_residual(LAW, samples)
    left = [fit_residual(LAW, samples[:k] + samples[k + 1 :]) for k in range(4)]
    assert found is not None
    for name, span in found.intervals:
        values = np.array([getattr(one.process, name) for one in left if one is not None])
        spread = np.sqrt(3.0 * values.var())
        assert values.size == 4
        assert span is not None
        assert span.high - span.value == pytest.approx(3.1824 * spread, rel=1e-4)  # t of 3, 97.5 %


def test_a_slope_at_its_bound_has_no_interval() -> None:
    """It stays there whichever flight is left out: the jackknife has no spread."""
    even = replace(PROCESS, slope=0.0)
    found = fit_residual(LAW, [one for seed in range(4) for one in flown(seed, process=even)])
    assert found is not None
    assert found.process.slope < 1e-6
    spans = dict(found.intervals)
    assert spans["slope"] is None
    assert spans["floor"] is not None
    assert spans["floor"].low <= PROCESS.floor <= spans["floor"].high


def test_without_rows_under_another_vehicle_there_is_no_process() -> None:
    assert fit_residual(LAW, [replace(one, exposed=one.exposed & False) for one in flown(0)]) is None


def test_a_model_file_keeps_the_process_and_one_without_is_as_before() -> None:
    assert decode(encode(ModelFile(LAW, residual=PROCESS))).residual == PROCESS
    assert "residual" not in encode(ModelFile(LAW))
    assert decode(encode(ModelFile(LAW))).residual is None


def prediction(t: float, eta: float) -> Interference:
    """Return a prediction of downwash on the lower of two vehicles."""
    acc, std = np.zeros((2, 3)), np.full((2, 3), np.nan)
    acc[0, 2], std[:, 2] = eta, 0.5
    return Interference(t, NAMES, acc, std, np.full(2, InterferenceStatus.VALID, dtype=np.uint8))


def corrected(delay: int, ticks: int = 5000) -> tuple[Array, Array, Array]:
    """Return the residual, what is left after the correction and the deviation claimed, (ticks,)."""
    block, rng = ResidualCorrector(PROCESS), np.random.default_rng(5)
    eta = -2.0 * np.ones(ticks)
    residual = PROCESS.std(eta) * unit_process(rng, ticks)
    seen = eta + residual + PROCESS.noise * rng.standard_normal(ticks)
    left, std = np.empty(ticks), np.empty(ticks)
    for k in range(ticks):
        if k >= delay:
            block.measure(STEP * (k - delay), NAMES, np.array([seen[k - delay], np.nan]))
        answer = block.update(prediction(STEP * k, eta[k]))
        left[k], std[k] = eta[k] + residual[k] - answer.acc[0, 2], answer.std[0, 2]
    return residual[100:], left[100:], std[100:]


@pytest.mark.parametrize("delay", [1, 2, 5])
def test_the_correction_leaves_what_it_claims_and_less_than_the_model_alone(delay: int) -> None:
    residual, left, std = corrected(delay)
    share = PROCESS.correlation(STEP * delay)
    assert left.std() == pytest.approx(std[-1], rel=0.15)  # 500 correlation times: 3 %
    assert left.var() < (1.0 - 0.5 * share**2) * residual.var()
    assert left.var() > (1.0 - share**2) * residual.var() * 0.8  # nobody knows more than the last residual


def test_an_offset_seen_in_clear_air_is_no_residual_under_the_wake() -> None:
    block = ResidualCorrector(PROCESS)
    for k in range(2000):
        block.update(prediction(STEP * k, 0.0))
        block.measure(STEP * k, NAMES, np.array([0.25, 0.0]))
    for k in range(2000, 2005):
        answer = block.update(prediction(STEP * k, -2.0))
        block.measure(STEP * k, NAMES, np.array([-1.75, 0.0]))
    assert answer.acc[0, 2] == pytest.approx(-2.0, abs=0.02)


@pytest.mark.parametrize("name", ["low", "new"])
def test_a_vehicle_that_appears_or_vanishes_changes_nothing_of_the_others(name: str) -> None:
    """`top` has an offset of 0.2 m/s^2 and a residual; beside it one vanishes, or comes."""

    def answers(names_at: Callable[[int], Names]) -> list[Interference]:
        block, found = ResidualCorrector(PROCESS), []
        for k in range(1000):
            names, n = names_at(k), len(names_at(k))
            acc, std = np.zeros((n, 3)), np.full((n, 3), 0.5)
            acc[:, 2] = 0.0 if k < 900 else -1.5
            valid = np.full(n, InterferenceStatus.VALID, dtype=np.uint8)
            found.append(block.update(Interference(STEP * k, names, acc, std, valid)))
            block.measure(STEP * k, names, acc[:, 2] + (0.2 if k < 900 else 0.7))
        return found

    def changing(k: int) -> Names:
        there = k < 940 if name == "low" else k >= 940
        return (name, "top") if there else ("top",)

    for k, (one, other) in enumerate(zip(answers(lambda _: ("top",)), answers(changing), strict=True)):
        row = other.names.index("top")
        assert other.acc[row, 2] == one.acc[0, 2], k
        assert other.std[row, 2] == one.std[0, 2], k
    assert one.acc[0, 2] == pytest.approx(-1.5 + 0.5 * PROCESS.correlation(STEP), abs=0.05)


def test_nothing_old_unknown_or_invalid_corrects() -> None:
    block = ResidualCorrector(PROCESS)
    assert block.update(prediction(0.0, -2.0)).acc[0, 2] == -2.0  # nothing measured
    block.measure(0.0, NAMES, np.array([-1.0, np.nan]))
    block.measure(0.0, NAMES, np.array([9.0, 9.0]))  # not later than the last
    block.measure(0.005, NAMES, np.array([9.0, 9.0]))  # of a time without prediction
    answer = block.update(prediction(0.01, -2.0))
    assert -2.0 < answer.acc[0, 2] < -1.0
    assert answer.acc[1, 2] == 0.0
    gone = replace(prediction(0.02, 0.0), status=np.full(2, InterferenceStatus.NO_MODEL, dtype=np.uint8))
    assert block.update(gone) is gone
    assert block.update(prediction(OLDEST + 0.02, -2.0)).acc[0, 2] == -2.0
    block.reset()
    assert block.update(prediction(0.0, -2.0)).acc[0, 2] == -2.0


@pytest.mark.parametrize("off", [3.0, 1e9, -0.05, -3.0])
def test_a_prediction_under_a_wrong_stamp_unlearns_nothing(off: float) -> None:
    right, got = ResidualCorrector(PROCESS), ResidualCorrector(PROCESS)
    for k in range(1000):
        now = prediction(STEP * k, 0.0 if k < 900 else -2.0)
        if k == 899:
            assert got.update(replace(now, t=now.t + off)).acc[0, 2] == 0.0
            continue
        np.testing.assert_array_equal(got.update(now).acc, right.update(now).acc)
        for block in (right, got):
            block.measure(now.t, NAMES, now.acc[:, 2] + 0.25)


def test_a_predictor_corrected_by_accelerometer_and_command_knows_an_unmodelled_push() -> None:
    """The lower of a hovering stack is pushed by 0.5 m/s^2 more than the law says; the next tick knows."""
    vehicle, still = CRAZYFLIE_2_1, np.zeros((2, 3))
    pos = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 1.5]])
    plain, block = InteractionPredictor(LAW), CorrectedPredictor(InteractionPredictor(LAW), PROCESS, vehicle)
    law = plain.update(resting_state(0.0, NAMES, pos)).acc[0, 2]
    thrust = np.full(2, vehicle.hover_thrust)
    for k in range(10):
        t = STEP * k
        state = resting_state(t, NAMES, pos)
        answer = block.update(state)
        force = np.array([[0.0, 0.0, GRAVITY + law - 0.5], [0.0, 0.0, GRAVITY]])
        command = level_command(t, NAMES, thrust)
        block.sense(state, command, SwarmImu(t, NAMES, force, still))
    assert answer.acc[0, 2] == pytest.approx(law - 0.5 * PROCESS.correlation(STEP), abs=0.05)
    assert answer.acc[1, 2] == pytest.approx(0.0, abs=1e-6)  # whose push is as predicted
    assert answer.std[0, 2] < PROCESS.std(np.array(law))
    assert block.update(state) is answer  # asked for again after its tick was measured
    block.update(replace(state, t=t - 0.5 * STEP))
    assert block.update(state) is answer  # and after a late one


@pytest.mark.parametrize("back", [0.02, 0.4, 100.0])
def test_a_push_measured_after_time_went_back_is_that_of_settled_rotors(back: float) -> None:
    vehicle, still = CRAZYFLIE_2_1, np.zeros((2, 3))
    force = np.tile([0.0, 0.0, GRAVITY], (2, 1))

    def pushes(times: tuple[float, ...]) -> Array:
        block, found = MeasuredPush(vehicle), np.zeros(2)
        for t, share in zip(times, (0.5, 1.0, 1.0), strict=True):
            state = resting_state(t, NAMES, still)
            thrust = np.full(2, share * vehicle.hover_thrust)
            command = level_command(t, NAMES, thrust)
            found = block.update(state, command, SwarmImu(t, NAMES, force, still))
        return found

    found = pushes((200.0, 200.0 - back, 200.01 - back))
    np.testing.assert_allclose(found, pushes((0.0, LONGEST_STEP, LONGEST_STEP + STEP)), atol=1e-9)
    assert np.abs(found).max() < 0.5 * GRAVITY * np.exp(-LONGEST_STEP / vehicle.thrust_lag)
