"""Recorded flights replayed through estimators: motion, degradations, held-out errors, divergence."""

import json
from dataclasses import replace

import numpy as np
import pytest

from q2q_model.documents.json_file import with_nulls
from q2q_model.flights.flight_log import FlightLog
from q2q_model.flights.joined_flight import flight_from_signals
from q2q_model.geometry.rotations import quat_from_euler, quat_multiply, rotate
from q2q_model.recordings.flight_recording import Recording
from q2q_model.signals.values import MocapFrame
from q2q_model.vehicle.constants import GRAVITY
from q2q_sim.experiments.estimators.estimate_errors import (
    ReplayedErrors,
    replayed_errors,
    settled_ticks,
    summary,
)
from q2q_sim.experiments.estimators.estimator_table import (
    error_table,
    errors_json,
    flight_table_of,
    print_whole,
)
from q2q_sim.experiments.estimators.mocap_degradations import CONDITIONS, given_samples
from q2q_sim.experiments.estimators.recorded_motion import RecordedMotion, recorded_motion
from q2q_sim.experiments.estimators.replayed_estimates import (
    ALL_AXES,
    filtered_motion,
    predicted_positions,
    sent_poses,
)
from q2q_sim.firmware.estimator import DT, NOISE_STEPS
from q2q_sim.firmware.extended_kalman import ExtendedKalmanParams, process_noise

T = np.arange(0.0, 12.0, DT)
RATE, RADIUS = 2.0 * np.pi / 4.0, 0.4
"""A circle of 0.4 m in 4 s, a metre high; from 1 to 2.5 s it takes off and gathers speed."""
STEADY = (T > 3.0) & (T < 11.0)
UP = np.array([0.0, 0.0, 1.0])


def circle(askew: float = 0.0, missing: slice = slice(0, 0)) -> Recording:
    """Return a recording of a vehicle on a circle that tilts as it must; its markers are `askew` [rad]."""
    share = np.clip((T - 1.0) / 1.5, 0.0, 1.0)
    gathered = share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
    turned = RATE * DT * np.cumsum(gathered)
    pos = np.stack([RADIUS * np.sin(turned), RADIUS * np.cos(turned), gathered], axis=1)
    force = np.gradient(np.gradient(pos, DT, axis=0), DT, axis=0) + GRAVITY * UP
    roll = -np.arcsin(force[:, 1] / np.linalg.norm(force, axis=1))
    level = quat_from_euler(roll, np.arctan2(force[:, 0], force[:, 2]), np.zeros_like(roll))
    quat = quat_multiply(level, quat_from_euler(0.0, askew, 0.0))
    frames = [
        MocapFrame(t=t, names=("cf1",), pos=pos[k : k + 1], quat=quat[k : k + 1])
        for k, t in enumerate(T)
        if not missing.start <= k < missing.stop
    ]
    return Recording(flight_from_signals("circle", {"mocap": frames}).flight)


@pytest.fixture(scope="module")
def motion() -> RecordedMotion:
    return recorded_motion(circle())


def test_on_a_circle_the_accelerometer_reads_thrust(
    motion: RecordedMotion,
) -> None:
    force = motion.specific_force_body[STEADY]
    np.testing.assert_allclose(force[:, 2], np.hypot(GRAVITY, RADIUS * RATE**2), atol=2e-3)
    # the circle is flown two and a quarter times, so that the mean tilt is not quite zero
    np.testing.assert_allclose(force[:, :2], 0.0, atol=0.03)


def test_markers_that_are_askew_do_not_tilt_the_vehicle() -> None:
    straight, askew = recorded_motion(circle()), recorded_motion(circle(askew=0.07))
    thrust = rotate(straight.body_quat[STEADY], UP)
    np.testing.assert_allclose(rotate(askew.body_quat[STEADY], UP), thrust, atol=1e-4)
    assert np.abs(rotate(askew.quat[STEADY], UP) - thrust)[:, 0].min() > 0.05


def test_a_recorded_estimate_is_resampled_in_metres_and_refused_in_millimetres() -> None:
    one = circle()
    own = one.flight.mocap_pos + 0.01
    log = FlightLog(one.flight.t, one.flight.names, ("est_x", "est_y", "est_z"), ("m",) * 3, own)
    found = recorded_motion(replace(one, log=log))
    assert found.own_pos is not None
    np.testing.assert_allclose(found.own_pos, found.pos + 0.01, atol=1e-6)
    with pytest.raises(
        ValueError, match=r"the estimate \(est_x, est_y, est_z\) in circle reach .* in metres"
    ):
        recorded_motion(replace(one, log=replace(log, values=1e3 * own)))


def test_rows_without_a_sample_are_neither_given_nor_compared() -> None:
    found = recorded_motion(circle(missing=slice(500, 520)))
    assert not found.seen[501:519].any()
    assert found.seen[:499].all()
    assert not given_samples(found, "100 Hz", 0)[501:519].any()


def test_stamps_that_jitter_thin_no_samples_and_hide_no_hole() -> None:
    whole = circle(missing=slice(500, 520)).flight
    jitter = np.random.default_rng(1).uniform(-0.4, 0.4, len(whole.t)) * DT
    jitter[0] = 0.4 * DT  # the times of the ticks are counted from here
    found = recorded_motion(Recording(replace(whole, t=whole.t + jitter)))
    expected = np.ones(len(found.seen), dtype=np.bool_)
    expected[500:520] = False
    np.testing.assert_array_equal(found.seen, expected)


def test_cuts_take_what_they_say_and_begin_in_flight(motion: RecordedMotion) -> None:
    flying = slice(240, 1000)
    shares = {name: given_samples(motion, name, 3)[flying].mean() for name in CONDITIONS}
    assert shares["100 Hz"] == 1.0
    assert shares["10 Hz"] == pytest.approx(0.1, abs=0.01)
    assert shares["30 % lost"] == pytest.approx(0.7, abs=0.06)  # 3.7 standard deviations of 790 draws
    assert shares["1 s away"] == pytest.approx(0.75, abs=0.13)  # two whole periods of 4 s, less a part
    assert all(given_samples(motion, name, 3)[:200].all() for name in CONDITIONS)


def test_a_pose_that_is_moved_on_lies_ahead_on_the_path(motion: RecordedMotion) -> None:
    run = filtered_motion(motion, motion.seen)
    plain, moved = sent_poses([run], 0.0), sent_poses([run], 0.02)
    late = slice(400, 900)
    np.testing.assert_allclose(moved.pos[late][:-2, 0], motion.pos[late][2:], atol=1e-3)
    assert np.linalg.norm(plain.pos[late][:-2, 0] - motion.pos[late][2:], axis=1).min() > 0.01


def test_the_filters_estimate_of_a_sample_does_not_know_it(motion: RecordedMotion) -> None:
    """A jump of one sample shows in the error of that tick in full."""
    jumped = replace(motion, pos=motion.pos + 0.05 * (np.arange(len(T)) == 600)[:, None])
    runs = [filtered_motion(one, one.seen) for one in (motion, jumped)]
    given = motion.seen[:, None]
    before, after = (predicted_positions([run], given)[600, 0] for run in runs)
    np.testing.assert_allclose(after, before, atol=1e-12)


def test_judgement_waits_until_samples_have_come_again() -> None:
    given = np.ones((400, 1), dtype=np.bool_)
    given[100:200] = False
    calm = settled_ticks(given)[:, 0]
    assert calm[:114].all()
    assert not calm[116:245].any()
    assert calm[250:].all()


def test_poses_moved_on_by_their_delay_are_better_than_stock_and_nothing_diverges(
    motion: RecordedMotion,
) -> None:
    found = {(one.condition, one.estimator): one for one in replayed_errors(motion, range(1))}
    assert sum(one.diverged for one in found.values()) == 0
    speed, delay = RADIUS * RATE, 0.02
    stock, fed = (summary([found["100 Hz", name]]).median for name in ("stock", "fed"))
    assert stock > 0.5 * speed * delay
    assert fed < 0.3 * stock
    assert summary([found["1 s away", "filter"]]).worst > 0.3  # it holds the position for 0.65 s
    undegraded = np.count_nonzero(motion.flying & motion.seen)
    assert len(found["100 Hz", "filter"].errors) == undegraded
    assert len(found["10 Hz", "filter"].errors) == pytest.approx(0.9 * (undegraded - 100), abs=10)
    document = errors_json(list(found.values()), 1)
    assert isinstance(document, dict)
    assert len(document["pooled"]) == len(found)  # type: ignore[arg-type]  # a list of them


def test_the_numbers_of_an_estimate_that_diverges_beyond_all_numbers_are_json() -> None:
    errors = np.array([0.01, 0.02, 0.03, np.inf])
    replays = [ReplayedErrors(str(k), "10 Hz", "filter", errors, 1, 1) for k in range(3)]
    document = with_nulls(errors_json(replays, 1))
    assert isinstance(document, dict)
    (pooled,) = document["pooled"]
    assert (pooled["median_m"], pooled["worst_m"]) == (pytest.approx(0.025), None)
    json.dumps(document, allow_nan=False)


def test_the_build_with_all_axes_trusts_them_alike() -> None:
    """procNoiseAcc_xy and _z are both 0.5 there (kalman_core.c); z has 1.0 in the other build."""
    added = np.sqrt(np.diag(process_noise(ALL_AXES)) / NOISE_STEPS) * NOISE_STEPS / DT
    np.testing.assert_allclose(added[3:6], 0.5)
    stock = np.sqrt(np.diag(process_noise(ExtendedKalmanParams())) / NOISE_STEPS) * NOISE_STEPS / DT
    np.testing.assert_allclose(stock[3:6], [0.5, 0.5, 1.0])


def test_the_interval_of_a_median_spans_the_flights() -> None:
    flights = [ReplayedErrors(str(k), "", "", np.full(10, 1.0 + k), 1, 0) for k in range(5)]
    pooled = summary(flights)
    assert pooled.median == 3.0
    assert pooled.interval is not None
    assert 1.0 <= pooled.interval[0] < 3.0 < pooled.interval[1] <= 5.0
    assert summary(flights[:2]).interval is None


def test_the_table_keeps_its_unit_and_its_numbers_in_a_pipe(capsys: pytest.CaptureFixture[str]) -> None:
    errors = np.linspace(0.0, 12.3456, 200)  # [m]
    found = [ReplayedErrors(f"flight [{k}]", "30 % lost", "all axes", errors + k, 200, 3) for k in range(5)]
    print_whole(error_table(found))
    print_whole(flight_table_of(found))
    out = capsys.readouterr().out
    assert "Distance from motion capture [mm], 5 flights" in out
    assert "Median of each flight [mm]" in out
    assert "flight [3]" in out
    worst, median = 1e3 * (errors.max() + 4.0), 1e3 * np.median(errors + 2.0)
    assert f" {worst:.1f} " in out
    assert f" {median:.1f} " in out
    assert max(len(line) for line in out.splitlines()) > 80
    assert "…" not in out


def test_a_slower_recording_is_refused_with_its_rate() -> None:
    third = np.arange(0, T.size, 3)
    whole = circle().flight
    slow = replace(whole, t=T[third], mocap_pos=whole.mocap_pos[third], mocap_quat=whole.mocap_quat[third])
    with pytest.raises(
        ValueError, match=r"flight circle has motion capture at 33 Hz; must be at least 80 Hz"
    ):
        recorded_motion(Recording(slow))


@pytest.mark.parametrize("height", [0.0, 0.12])
def test_what_never_flies_is_refused(height: float) -> None:
    """A vehicle that tips or hops by 0.12 m does not leave the ground."""
    flight = circle().flight
    grounded = replace(flight, mocap_pos=flight.mocap_pos * [1.0, 1.0, height])
    says = r"flight circle is 0\.0 s more than 0\.3 m above its start; must be at least 5 s"
    with pytest.raises(ValueError, match=says):
        recorded_motion(Recording(grounded))


def test_quaternions_in_another_order_are_refused() -> None:
    flight = circle().flight
    scalar_first = replace(flight, mocap_quat=flight.mocap_quat[..., [3, 0, 1, 2]])
    says = r"flight circle: body z of cf1 points -1\.00 upwards .* quaternions are in the order x y z w"
    with pytest.raises(ValueError, match=says):
        recorded_motion(Recording(scalar_first))


def test_poses_without_attitudes_are_refused_with_what_they_lack() -> None:
    flight = circle().flight
    unturned = replace(flight, mocap_quat=np.full_like(flight.mocap_quat, np.nan))
    with pytest.raises(
        ValueError, match=r"flight circle has no attitudes: record them, in a table as qx, qy"
    ):
        recorded_motion(Recording(unturned))
