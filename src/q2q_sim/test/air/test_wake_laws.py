"""Tests of the true downwash: signs, the written laws, delay, and what the sources did."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from q2q_model.vehicle.constants import CRAZYFLIE_2_0
from q2q_sim.air.wake_laws import WakeLaw, pair_eta, wake_by_name
from q2q_sim.plant.swarm import Swarm

DRAFTS = pytest.mark.parametrize("kind", [WakeLaw.PAPER, WakeLaw.MEASURED])


def _pair(kind: WakeLaw, dz: float, dxy: float = 0.0) -> Swarm:
    start = np.array([[0.0, 0.0, 1.0, 0.0], [dxy, 0.0, 1.0 + dz, 0.0]])
    return Swarm(("cf1", "cf2"), CRAZYFLIE_2_0, start, kind)


@DRAFTS
def test_the_lower_vehicle_is_pushed_down_and_the_upper_a_little_up(kind: WakeLaw) -> None:
    lower, upper = _pair(kind, dz=0.5).downwash()[:, 2]
    assert lower < -0.3
    assert 0.0 < upper <= 0.2 * -lower


@DRAFTS
def test_exchanged_vehicles_feel_exchanged_downwashs(kind: WakeLaw) -> None:
    np.testing.assert_allclose(
        _pair(kind, -0.5, 0.05).downwash(), _pair(kind, 0.5, 0.05).downwash()[::-1], rtol=1e-12
    )


def test_the_paper_wake_is_the_law_of_the_notes() -> None:
    for dz, dxy in ((0.5, 0.0), (1.0, 0.1), (0.3, 0.2)):
        law = -0.392 * ((0.33 + 0.5) / (0.33 + dz)) ** 2 * math.exp(-(dxy**2) / 2 / (0.06 + 0.08 * dz) ** 2)
        eta = _pair(WakeLaw.PAPER, dz, dxy).downwash()[:, 2]
        np.testing.assert_allclose(eta, [law, -0.2 * law], rtol=1e-12)


def test_the_measured_wake_is_the_fitted_law_at_its_reference_height() -> None:
    for dxy in (0.0, 0.05, 0.1):
        eta = _pair(WakeLaw.MEASURED, 0.4, dxy).downwash()[0, 2]
        assert eta == pytest.approx(-2.5 * math.exp(-(dxy**2) / (2 * 0.054**2)), rel=1e-12)
    assert _pair(WakeLaw.MEASURED, 1.0).downwash()[0, 2] == pytest.approx(
        -2.5 * math.exp(-0.95 * 0.6), rel=1e-12
    )


@DRAFTS
@settings(deadline=None)
@given(dz=st.floats(-0.3, 0.3), step=st.floats(1e-6, 1e-3))
def test_the_change_of_roles_is_smooth(kind: WakeLaw, dz: float, step: float) -> None:
    # the steepest slope is that of the cubic, 0.75 / b times the whole change, plus the laws' own
    after, before = (np.array(pair_eta(int(kind), 0.0, height)) for height in (dz + step, dz))
    assert np.abs(after - before).max() <= 60.0 * step


def test_a_measured_downwash_arrives_late_by_its_way_over_its_speed() -> None:
    # the source jumps aside at once; the push at dz = 0.75 m lasts 0.1 s longer
    swarm = _pair(WakeLaw.MEASURED, 0.75)
    hover = np.tile([CRAZYFLIE_2_0.hover_thrust, 0.0, 0.0, 0.0], (1, 2, 1))
    drive = np.array([[0.0] * 3 + [1.0] * 4] * 2)
    before = swarm.downwash()[0, 2]
    swarm.state[1, 0] = 0.3
    pushed = []
    for _ in range(100):
        swarm.step(hover, drive)
        pushed.append(swarm.downwash()[0, 2])
    late = np.array(pushed) < 0.5 * before
    assert before < -1.0
    assert int(late.sum()) * 0.002 == pytest.approx(0.75 / 7.5, abs=0.004)  # two physics steps
    assert not late[-1]


def test_a_vehicle_without_thrust_makes_no_measured_downwash() -> None:
    swarm = _pair(WakeLaw.MEASURED, 0.5)
    swarm.air.ring[:, 1, 3] = 0.0
    np.testing.assert_array_equal(swarm.downwash()[:, 2] == 0.0, [True, False])


def test_two_sources_add_up() -> None:
    start = np.array([[0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 1.5, 0.0], [0.05, 0.0, 2.0, 0.0]])
    three = Swarm(("a", "b", "c"), CRAZYFLIE_2_0, start, WakeLaw.PAPER).downwash()[0, 2]
    pairs = _pair(WakeLaw.PAPER, 0.5).downwash()[0, 2] + _pair(WakeLaw.PAPER, 1.0, 0.05).downwash()[0, 2]
    assert three == pytest.approx(pairs, rel=1e-12)


def test_an_unknown_wake_is_refused_with_the_known_ones() -> None:
    with pytest.raises(ValueError, match="unknown wake 'storm'; choose one of none, paper, measured"):
        wake_by_name("storm")
