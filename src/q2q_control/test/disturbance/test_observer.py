"""The observer finds a constant push, follows its own poles, and survives gaps and newcomers."""

import numpy as np

from q2q_control.disturbance.observer import JUMP, DisturbanceObserver, Estimate, MeasuredRows, Measurement
from q2q_control.disturbance.tracker import measured_rows
from q2q_control.inputs.alignment import ETA, POS, QUAT, TRACK, VEL
from q2q_model.geometry.rotations import rotate
from q2q_model.signals.values import TrackStatus
from q2q_model.vehicle.constants import GRAVITY

RNG = np.random.default_rng(3)
DT = 0.01
"""[s]"""


def seen(t: float, height: float, acc: float, fresh: bool = True) -> Measurement:
    """Return a measurement of one vehicle that moves vertically."""
    pos, acc_by_thrust = np.array([[0.0, 0.0, height]]), np.array([[0.0, 0.0, acc]])
    return Measurement(t, ("cf1",), MeasuredRows(pos, np.zeros((1, 3)), acc_by_thrust, np.array([fresh])))


def falling(push: float, ticks: int, bandwidth: tuple[float, float] = (12.0, 8.0)) -> list[Estimate]:
    """Return the estimates of a vehicle that a constant push accelerates from rest."""
    observer = DisturbanceObserver(*bandwidth, 10.0)
    return [observer.update(seen(k * DT, 0.5 * push * (k * DT) ** 2, 0.0)) for k in range(ticks)]


def test_measured_rows_are_the_tables_and_thrust_turned_into_the_world():
    table = RNG.normal(size=(3, 25))
    table[:, QUAT] /= np.linalg.norm(table[:, QUAT], axis=1)[:, None]
    table[:, TRACK] = [TrackStatus.TRACKED, TrackStatus.COASTING, TrackStatus.TRACKED]
    before, mass = RNG.normal(size=(3, 3)), 0.035
    now, mean = RNG.uniform(0.2, 0.5, (2, 3))
    usable = np.array([True, True, False])
    measured, acc, eta = measured_rows((table, usable), before, (now, mean), mass)
    rows = MeasuredRows(*measured)
    up = rotate(table[:, QUAT], np.array([0.0, 0.0, 1.0]))
    weight = np.array([0.0, 0.0, GRAVITY])
    assert np.allclose(acc, now[:, None] / mass * up - weight, atol=1e-13)
    explained = mean[:, None] / mass * up - weight + 0.5 * (before + table[:, ETA])
    assert np.allclose(rows.acc, explained, atol=1e-13)
    for found, columns in ((rows.pos, POS), (rows.vel, VEL), (eta, ETA)):
        assert np.array_equal(found, table[:, columns])
    assert rows.fresh.tolist() == [True, False, False]


def test_a_constant_push_is_found_exactly_and_with_its_sign():
    last = falling(-0.7, 400)[-1]
    # 32 time constants of 1/8 s: what is left is below rounding of the position, 1e-16 / dt^2
    assert abs(last.disturbance[0, 2] + 0.7) < 1e-9
    assert abs(last.vel[0, 2] + 0.7 * 399 * DT) < 1e-9
    assert np.array_equal(last.disturbance[0, :2], [0.0, 0.0])


def test_the_estimate_follows_with_the_three_poles_it_was_given():
    errors = np.array([1.0 - e.disturbance[0, 2] for e in falling(1.0, 60, (12.0, 5.0))])
    fast, slow = np.exp(-12.0 * DT), np.exp(-5.0 * DT)
    c3, c2, c1, c0 = np.poly([fast, fast, slow])
    # (E - fast)^2 (E - slow) applied to the error sequence leaves nothing
    residue = c3 * errors[3:] + c2 * errors[2:-1] + c1 * errors[1:-2] + c0 * errors[:-3]
    assert np.abs(residue[1:]).max() < 1e-9


def test_thrust_that_is_known_is_not_taken_for_a_disturbance():
    observer = DisturbanceObserver(12.0, 8.0, 10.0)
    for k in range(100):
        estimate = observer.update(seen(k * DT, 0.5 * 2.0 * (k * DT) ** 2, 2.0))
    assert abs(estimate.disturbance[0, 2]) < 1e-9
    assert abs(estimate.vel[0, 2] - 2.0 * 99 * DT) < 1e-9


def test_without_a_fresh_position_the_estimate_follows_the_model():
    observer = DisturbanceObserver(12.0, 8.0, 10.0)
    for k in range(50):
        before = observer.update(seen(k * DT, 0.1, 0.0))
    after = observer.update(seen(50 * DT, 99.0, 0.0, fresh=False))
    assert np.allclose(after.pos, before.pos, atol=1e-12)
    assert np.allclose(after.disturbance, before.disturbance)


def test_a_gap_starts_anew_and_the_disturbance_stays_within_its_limit():
    observer = DisturbanceObserver(12.0, 8.0, 0.5)
    for k in range(200):
        estimate = observer.update(seen(k * DT, -0.5 * 3.0 * (k * DT) ** 2, 0.0))
    assert estimate.disturbance[0, 2] == -0.5
    again = observer.update(seen(9.0, 1.0, 0.0))
    assert again.pos[0, 2] == 1.0
    assert again.disturbance[0, 2] == 0.0


def test_a_jump_of_the_position_restarts_the_estimate_and_is_no_disturbance():
    """Of 0.4 m, as when a marker is displaced; up to JUMP, it is taken for a movement."""
    for size, restarts in ((0.4, True), (1.001 * JUMP, True), (0.999 * JUMP, False)):
        observer = DisturbanceObserver(12.0, 8.0, 10.0)
        for k in range(200):
            before = observer.update(seen(k * DT, 0.0, 0.5))  # a push of -0.5 m/s^2 keeps it where it is
        after = observer.update(seen(200 * DT, size, 0.5))
        assert (after.pos[0, 2] == size) == restarts
        assert (after.disturbance[0, 2] == before.disturbance[0, 2]) == restarts
        assert abs(before.disturbance[0, 2] + 0.5) < 1e-5


def test_estimates_stay_with_their_names():
    observer = DisturbanceObserver(12.0, 8.0, 10.0)
    for k in range(100):
        observer.update(seen(k * DT, -0.5 * (k * DT) ** 2, 0.0))
    pos, zero = np.array([[0, 0, 1.0], [0, 0, -0.5]]), np.zeros((2, 3))
    two = MeasuredRows(pos, zero, zero, np.ones(2, np.bool_))
    estimate = observer.update(Measurement(1.0, ("cf2", "cf1"), two))
    assert estimate.disturbance[0, 2] == 0.0
    assert abs(estimate.disturbance[1, 2] + 1.0) < 0.02  # 8 time constants of 1/8 s, and faster poles
