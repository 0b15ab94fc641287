"""Gains from poses alone hold the gains that flew, or are said to be unknown."""

from dataclasses import replace

import numpy as np
import pytest
from made_flights import Pass, record_of

from q2q_model.downwash.no_interaction import NoInteraction
from q2q_model.identification.gains.gains_from_poses import gains_from_poses
from q2q_model.identification.gains.impulse_response import free_response
from q2q_model.vehicle.altitude_loop import AltitudeLoop
from q2q_model.vehicle.constants import CRAZYFLIE_2_0

SETTLES = Pass(law=NoInteraction(), start=0.3, noise=1e-4, seconds=12.0)


@pytest.mark.parametrize("lag", [0.0, CRAZYFLIE_2_0.thrust_lag])
@pytest.mark.parametrize(("k_p", "k_d"), [(0.81, 0.43), (8.0, 4.0)])
def test_vehicles_that_settle_show_gains_that_hold_those_that_flew(
    k_p: float, k_d: float, lag: float
) -> None:
    loop = AltitudeLoop(k_p, k_d, lag=lag)
    flights = [replace(SETTLES, name=f"from {start}", start=start, loop=loop) for start in (0.3, -0.2)]
    fit, notes = gains_from_poses([record_of(one) for one in flights], CRAZYFLIE_2_0)
    assert notes == []
    assert fit.holds
    assert 0.0 < fit.k_p.low <= k_p <= fit.k_p.high
    assert 0.0 < fit.k_d.low <= k_d <= fit.k_d.high


@pytest.mark.parametrize("gust", [0.0, 0.3])
@pytest.mark.parametrize(("k_p", "k_d"), [(8.0, 4.0), (2.0, 2.0)])
def test_vehicles_that_stay_at_their_references_show_no_gains(k_p: float, k_d: float, gust: float) -> None:
    """The loop that fits gusts and noise best is another one, and does not damp."""
    loop = AltitudeLoop(k_p, k_d, lag=CRAZYFLIE_2_0.thrust_lag)
    calm = replace(SETTLES, start=0.0, loop=loop, gust=gust, noise=5e-4)
    fit, (note,) = gains_from_poses([record_of(replace(calm, name=name)) for name in "ab"], CRAZYFLIE_2_0)
    assert not fit.holds
    assert (fit.k_p.low, fit.k_p.high, fit.k_d.low, fit.k_d.high) == (0.0, 200.0, 0.0, 50.0)
    assert note.startswith("the model file has no gains: a loop with no lag that settles")
    assert "moves vehicles nowhere 5 times as far from their references as the" in note


def test_vehicles_that_never_leave_their_references_show_no_gains() -> None:
    """As where the reference of a recording is the measured position: no loop leaves any residual."""
    exact = [record_of(replace(SETTLES, name=name, start=0.0, noise=0.0)) for name in "ab"]
    fit, (note,) = gains_from_poses(exact, CRAZYFLIE_2_0)
    assert not fit.holds
    assert (fit.k_p.low, fit.k_p.high, fit.k_d.low, fit.k_d.high) == (0.0, 200.0, 0.0, 50.0)
    assert "from their references as the 0 mm that it leaves unexplained" in note


def test_gains_stay_known_while_vehicles_hover_after_they_settled() -> None:
    """Of 60 s, noise of 2 mm is a fifth of the mean square deviation."""
    made = replace(SETTLES, start=0.07, noise=2e-3, seconds=60.0, loop=AltitudeLoop(8.0, 4.0))
    still = [record_of(replace(made, name=name)) for name in "ab"]
    fit, notes = gains_from_poses([replace(one, vel=np.zeros_like(one.vel)) for one in still], CRAZYFLIE_2_0)
    assert notes == []
    assert 0.0 < fit.k_p.low <= 8.0 <= fit.k_p.high < 16.0
    assert 0.0 < fit.k_d.low <= 4.0 <= fit.k_d.high < 8.0


def test_a_note_names_the_gain_that_may_be_zero() -> None:
    made = replace(SETTLES, start=0.1, noise=3e-3, loop=AltitudeLoop(8.0, 4.0))
    fit, (note,) = gains_from_poses([record_of(replace(made, name=name)) for name in "ab"], CRAZYFLIE_2_0)
    assert not fit.holds
    assert note.startswith("the model file has no gains: K_p of a loop with no lag may be 0: 19.4 [0, ")
    assert note.endswith("]: record the topics command and reference")


def test_an_integral_of_the_controller_leaves_intervals_that_hold_its_gains() -> None:
    loop, ticks = AltitudeLoop(k_p=8.0, k_d=4.0, k_i=1.0), 1000
    start = np.array([[0.3, -0.2], [0.0, 0.0]])
    error = free_response(loop, 0.01, start, np.zeros((ticks, 2)))
    error += 1e-4 * np.random.default_rng(0).standard_normal(error.shape)
    still = record_of(replace(SETTLES, seconds=0.01 * ticks))
    pos, vel = still.pos.copy(), np.zeros_like(still.vel)
    pos[..., 2] = still.ref[..., 0] + error
    fit, _ = gains_from_poses([replace(still, pos=pos, vel=vel)], CRAZYFLIE_2_0)
    assert fit.holds
    assert fit.k_p.low <= 8.0 <= fit.k_p.high
    assert fit.k_d.low <= 4.0 <= fit.k_d.high
