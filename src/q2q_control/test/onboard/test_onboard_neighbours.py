"""Neighbours of the firmware app: broadcast, dead-reckoned, refused or forgotten."""

import math

import numpy as np
import pytest
from native_apps import TICK_US, at_rest, hover, library, needs_cc

from q2q_control.onboard.model_header import STALE_S, AppRates
from q2q_control.onboard.native_app import NativeApp
from q2q_model.downwash.jet import MEASURED_LAW, MOVING_LAW, Jet
from q2q_model.signals.values import Array


@needs_cc
def test_a_neighbour_is_dead_reckoned_between_broadcasts_and_forgotten_when_it_is_silent() -> None:
    app, own, speed = NativeApp(library(MEASURED_LAW, AppRates())), hover(0.0, 0.0, 1.0), 0.5
    for k in range(20):
        source = hover(speed * 0.02 * k - 0.25, 0.0, 1.5)
        source[3] = speed
        app.hear_motion(7, 20_000 * k, source)
    width, peak = MEASURED_LAW.width, MEASURED_LAW.strength * math.exp(-MEASURED_LAW.decay_rate * 0.1)
    for age in (0.0, 0.1, STALE_S - 0.01):
        x = speed * (0.38 + age - 0.5 / MEASURED_LAW.travel_speed) - 0.25  # where the air left the source
        eta = app.downwash(own, 380_000 + round(1e6 * age))
        assert eta == pytest.approx(-peak * math.exp(-x * x / (2 * width * width)), rel=1e-4)
    assert app.downwash(own, 380_000 + round(1e6 * STALE_S) + 1000) == 0.0


@needs_cc
def test_broadcasts_round_to_millimetres() -> None:
    app = NativeApp(library(MEASURED_LAW))
    packet = app.broadcast(200, np.array([1.2344, -2.0, 32.767, -0.5, 0.0, -9.0, 0.3, -0.4, math.sqrt(0.75)]))
    assert packet is not None
    assert packet[0] == 200
    numbers = np.frombuffer(packet[1:], dtype="<i2")
    np.testing.assert_array_equal(numbers, [1234, -2000, 32767, -500, 0, -9000, 3000, -4000])
    above, own = hover(0.01, 0.0, 1.4), hover(0.0, 0.0, 1.0)
    sent = app.broadcast(200, above)
    assert sent is not None
    assert app.hear(sent, 0)
    other = NativeApp(library(MEASURED_LAW))
    assert other.hear_motion(200, 0, above)
    assert app.downwash(own, 0) == pytest.approx(other.downwash(own, 0), abs=1e-6)


@needs_cc
@pytest.mark.parametrize("axis", range(6))
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_position_or_speed_beyond_the_range_of_a_packet_is_not_broadcast(axis: int, sign: float) -> None:
    """Clipped to the range, it would be one where nobody is."""
    motion = hover(0.0, 0.0, 1.0)
    motion[axis] = sign * 32.77
    assert NativeApp(library(MEASURED_LAW)).broadcast(3, motion) is None


@needs_cc
@pytest.mark.parametrize("sick", [0, 5, 8])
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_a_motion_that_is_not_finite_is_not_broadcast(sick: int, value: float) -> None:
    """It became a valid packet: position 0, where others then felt a vehicle."""
    motion = hover(1.0, 2.0, 3.0)
    motion[sick] = value
    assert NativeApp(library(MEASURED_LAW)).broadcast(3, motion) is None


@needs_cc
def test_a_silent_neighbour_stays_forgotten_when_the_clock_has_wrapped() -> None:
    """Stamps are of 32 bits: half their period later an age is negative, a whole one later it is new."""
    heard, above, own = 1_000_000, hover(0.0, 0.0, 1.4), hover(0.0, 0.0, 1.0)
    fresh, app = NativeApp(library(MEASURED_LAW)), NativeApp(library(MEASURED_LAW))
    assert app.hear_motion(2, heard, above)
    assert app.downwash(own, heard) == pytest.approx(-MEASURED_LAW.strength, rel=1e-5)
    assert app.downwash(own, (heard + 2_150_000_000) % 2**32) == 0.0  # no step since: 35.8 min, age negative
    app.step(at_rest(heard + 300_000, own))  # steps go on every 2 ms; one is enough to forget
    for later in (2_150_000_000, 4_000_000_000, 2**32 + 100_000):
        assert app.downwash(own, (heard + later) % 2**32) == 0.0
    back, beside = (heard + 2_200_000_000) % 2**32, hover(0.02, 0.0, 1.4)
    assert app.hear_motion(2, back, beside)
    assert fresh.hear_motion(2, back, beside)
    assert app.downwash(own, back) == fresh.downwash(own, back) < -0.5


@needs_cc
def test_a_late_packet_is_refused_and_keeps_the_newer_ones() -> None:
    app, own = NativeApp(library(MEASURED_LAW)), hover(0.0, 0.0, 1.0)
    assert app.hear_motion(2, 40_000, hover(0.0, 0.0, 1.4))
    assert not app.hear_motion(2, 20_000, hover(5.0, 0.0, 1.4))
    assert app.downwash(own, 40_000) == pytest.approx(-MEASURED_LAW.strength, rel=1e-5)


@needs_cc
def test_of_six_neighbours_the_last_is_refused_until_one_is_silent() -> None:
    app = NativeApp(library(MEASURED_LAW))
    assert [app.hear_motion(k, 1000, hover(0.0, 0.0, 1.0 + k)) for k in range(1, 7)] == [True] * 5 + [False]
    assert not app.hear_motion(1, 1000, hover(0.0, 0.0, 2.0))  # a repeated stamp
    assert not app.hear_motion(1, 2000, np.full(9, np.nan))
    assert app.hear_motion(6, 1000 + round(1e6 * STALE_S) + 100_000, hover(0.0, 0.0, 1.4))


def crowd(seed: int) -> Array:
    """Return the motions of five vehicles above one at the origin and of seven that push it less, (12, 9)."""
    rng = np.random.default_rng(seed)
    above = [hover(*rng.uniform(-0.03, 0.03, 2), z) for z in rng.uniform(0.2, 0.6, 5)]
    below = [hover(*rng.uniform(-0.1, 0.1, 2), z) for z in rng.uniform(-1.0, 0.02, 4)]
    aside = [hover(x, 0.0, 0.5) for x in rng.uniform(0.2, 0.4, 3)]
    return np.array([*above, *below, *aside])


@needs_cc
@pytest.mark.parametrize("seed", range(5))
def test_of_a_crowd_the_nearest_five_are_felt_in_whatever_order_they_are_heard(seed: int) -> None:
    """The first five heard were felt, however far they were: -54 mm for -8 under the sixth."""
    own, others = hover(0.0, 0.0, 0.0), crowd(seed)
    felt, order = NativeApp(library(MEASURED_LAW)), np.random.default_rng(seed)
    nearest = NativeApp(library(MEASURED_LAW))
    for tick in range(3):
        for app, heard in ((felt, order.permutation(12)), (nearest, np.arange(5))):
            app.step(at_rest(tick * TICK_US, own))
            for number in heard.tolist():
                app.hear_motion(number, tick * TICK_US, others[number])
    eta = nearest.downwash(own, 2 * TICK_US)
    assert felt.downwash(own, 2 * TICK_US) == pytest.approx(eta, rel=1e-5)
    assert eta < -1.0
    assert nearest.unheard == 0
    assert felt.unheard >= 2 * 7


@needs_cc
@pytest.mark.parametrize("jet", [MEASURED_LAW, MOVING_LAW])
def test_eight_beside_a_vehicle_do_not_displace_the_one_above_it(jet: Jet) -> None:
    """With millimetres of noise they took each other's places and its own: -0.06 m/s^2 for -1.3."""
    grid = [hover(0.5 * i, 0.5 * j, 1.0) for i in (-1, 0, 1) for j in (-1, 0, 1) if i or j]
    own, above = hover(0.0, 0.0, 1.0), hover(0.0, 0.0, 2.0)
    among, alone = NativeApp(library(jet)), NativeApp(library(jet))
    noise, eta, stored = np.random.default_rng(0), [], set[int]()
    for tick in range(200):
        now = tick * TICK_US
        for app in (among, alone):
            app.step(at_rest(now, own))
            app.hear_motion(1, now, above)
        noisy = [beside + np.r_[noise.normal(0.0, 1e-3, 3), np.zeros(6)] for beside in grid]
        heard = {
            number for number, beside in enumerate(noisy, start=2) if among.hear_motion(number, now, beside)
        }
        if tick >= 100:  # the delay of the air is over
            eta.append(among.downwash(own, now))
            stored |= heard
    np.testing.assert_allclose(eta, alone.downwash(own, now), rtol=0.01)
    assert stored == {3, 5, 6, 8}  # those at 0.5 m, always


@needs_cc
def test_one_that_is_not_clearly_nearer_than_the_farthest_displaces_nobody_and_is_counted() -> None:
    app, own = NativeApp(library(MEASURED_LAW)), hover(0.0, 0.0, 0.0)
    assert all(app.hear_motion(k, 0, hover(0.0, 0.0, 1.0)) for k in range(1, 6))
    assert not app.hear_motion(6, 0, hover(0.0, 0.0, 0.5))
    assert app.unheard == 0  # the own position is unknown
    app.step(at_rest(0, own))
    for stamp, height in ((0, 1.0), (TICK_US, 0.9)):
        assert not app.hear_motion(6, stamp, hover(0.0, 0.0, height))
    assert app.unheard == 2
    assert not app.hear_motion(6, 2 * TICK_US, np.full(9, math.nan))
    assert app.unheard == 2
    assert app.hear_motion(7, 2 * TICK_US, hover(0.0, 0.0, 0.89))


@needs_cc
@pytest.mark.parametrize("gap", [1.19, 1.3])
def test_the_speed_of_a_third_vehicle_changes_nothing(gap: float) -> None:
    found = []
    for speed in (0.0, 2.0):
        app = NativeApp(library(MEASURED_LAW))
        for tick in range(30):
            far = hover(50.0 + speed * 1e-6 * TICK_US * tick, 0.0, 1.0)
            far[3] = speed
            app.hear_motion(1, tick * TICK_US, hover(0.0, 0.0, gap))
            app.hear_motion(2, tick * TICK_US, far)
            app.step(at_rest(tick * TICK_US, hover(0.0, 0.0, 0.0)))
        found.append(app.downwash(hover(0.0, 0.0, 0.0), 29 * TICK_US))
    assert found[0] == found[1]
    assert (found[0] == 0.0) is (gap > MEASURED_LAW.range)
