"""A landing is over when its duration has passed and all rest on the ground, however slow or high it is."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.polynomial import Polynomial
from procedure_bench import GROUND, HOME, PARAMS, ROOM, STEP, Bench, at_height, up

from q2q_control.flight_procedure.procedure_params import LandingParams
from q2q_control.flight_procedure.steps import Act, Call, Step

DESCENT = Polynomial([1.0, 0.0, 0.0, 0.0, -35.0, 84.0, -70.0, 20.0])
"""Share of the height that is left after a share of the duration: rest to rest, as planned on board."""
HIGH = (*ROOM[:5], 10.0)


def hovering(landing: LandingParams, height: float, settle_s: float) -> Bench:
    """Return a bench whose vehicles hover, and do not land by what the bench tells them."""
    params = replace(PARAMS, room=HIGH, take_off_height=height, settle_s=settle_s)
    bench = Bench(params, landing=landing, stuck={Act.LAND})
    assert bench.asked(Call.TAKE_OFF).granted
    return bench


def descend(bench: Bench, duration: float, until: float) -> None:
    """Let vehicles descend in a duration [s], until a time after its beginning [s]."""
    began, top = bench.t, float(bench.pos[0, 2]) - GROUND
    while bench.t < began + until and Act.DISARM not in bench.acts:
        share = min((bench.t - began) / duration, 1.0)
        bench.pos = at_height(bench.pos, GROUND + top * DESCENT(share))
        bench.vel = np.zeros((2, 3)) + up(top * DESCENT.deriv()(share) / duration)
        bench.wait(STEP)


def land(bench: Bench) -> float:
    """Call for a landing, and return its duration [s] when it is ordered."""
    assert bench.call(Call.LAND) is None
    while Act.LAND not in bench.acts:
        bench.wait(STEP)
    return bench.sent[-1].duration


SLOW = [LandingParams(landing_duration_min=duration) for duration in (3.0, 12.0, 30.0, 60.0)]


@pytest.mark.parametrize("settle_s", [0.5, 1.0])
@pytest.mark.parametrize("landing", SLOW, ids=[f"{one.landing_duration_min:g} s" for one in SLOW])
def test_no_motors_stop_during_a_slow_descent(landing: LandingParams, settle_s: float) -> None:
    """They were stopped at 7 cm after 20.5 of 30 s, and at 4 cm with the shortest settle_s in 12 s."""
    bench = hovering(landing, 0.5, settle_s)
    duration, began = land(bench), bench.t
    assert duration == landing.landing_duration_min
    descend(bench, duration, duration + 2.0)
    assert Act.DISARM in bench.acts
    assert duration <= bench.t - began <= duration + settle_s + 2.0 * STEP
    assert bench.pos[:, 2] == pytest.approx(GROUND)
    bench.wait(2.0 * STEP)
    assert bench.answer().granted


FROM_HIGH = [(2.5, 0.4), (4.0, 0.4), (5.0, 0.4), (1.5, 0.1), (1.5, 0.05)]
"""Heights [m] and mean speeds [m/s]."""


@pytest.mark.parametrize(("height", "speed"), FROM_HIGH)
def test_a_landing_from_high_up_is_waited_for_to_its_end(height: float, speed: float) -> None:
    """From 4 m it failed after 8 of 10 s, at 0.14 m: the time allowed shrank with the height."""
    bench = hovering(LandingParams(land_speed=speed), height, PARAMS.settle_s)
    duration = land(bench)
    assert duration == pytest.approx(height / speed)
    descend(bench, duration, duration + 2.0)
    bench.wait(2.0 * STEP)
    assert bench.answer().granted


def test_a_landing_from_high_up_that_does_not_come_down_fails_after_its_duration() -> None:
    bench = hovering(LandingParams(), 4.0, PARAMS.settle_s)
    duration, began = land(bench), bench.t
    while not bench.replies:
        bench.wait(STEP)
    assert "not on the ground: cf1 is at 3.20 m, 4.00 m from its goal" in bench.answer().reason
    assert bench.t - began == pytest.approx(duration + PARAMS.step_timeout_s, abs=3.0 * STEP)


def test_vehicles_that_stand_on_the_ground_wait_for_the_end_of_a_landing_that_is_given_anew() -> None:
    bench = hovering(LandingParams(landing_duration_min=12.0), 0.5, PARAMS.settle_s)
    land(bench)
    bench.wait(12.0 + PARAMS.step_timeout_s + 0.1)
    assert not bench.answer().granted
    bench.move(HOME)
    bench.sent.clear()
    land(bench)
    began = bench.t
    while Act.DISARM not in bench.acts:
        bench.wait(STEP)
    assert bench.t - began == pytest.approx(12.0, abs=3.0 * STEP)


def test_vehicles_that_land_slowly_by_themselves_are_disarmed_at_its_end() -> None:
    bench = hovering(LandingParams(landing_duration_min=30.0), 0.5, PARAMS.settle_s)
    assert bench.asked(Call.FLY, 3.0).granted
    bench.reports = tuple(replace(one, flies=False) for one in bench.reports)
    bench.wait(STEP)
    assert bench.procedure.step is Step.LANDING
    began = bench.t
    descend(bench, 30.0, 32.0)
    assert bench.t - began == pytest.approx(30.0, abs=3.0 * STEP)


def test_vehicles_whose_motors_were_cut_are_disarmed_once_they_rest() -> None:
    bench = hovering(LandingParams(landing_duration_min=30.0), 0.5, PARAMS.settle_s)
    assert bench.asked(Call.FLY, 3.0).granted
    bench.reports = tuple(replace(one, flies=False, cut=True) for one in bench.reports)
    bench.move(HOME)
    bench.wait(PARAMS.settle_s + 0.1)
    assert bench.acts[-1] is Act.DISARM
