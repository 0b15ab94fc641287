"""The margin of a policy is the relative distance of the worst value from the limit, in closed form."""

from dataclasses import replace

import numpy as np
import pytest
from hovering_trace import hovering

from q2q_model.signals.values import TrackStatus
from q2q_model.vehicle.constants import GRAVITY
from q2q_sim.monitors.policies import POLICIES, Circumstances, FlightTrace, judge
from q2q_sim.monitors.policies.margins import MOST, margins

TICKS = 100
SHAPE = (TICKS, 2)
AROUND = Circumstances()
LIMITS = AROUND.limits


def trace() -> FlightTrace:
    """Return a flight of two vehicles that hover 1 m apart, both exactly at their setpoints."""
    return hovering(np.array([[2.0, -1.0, 1.0], [2.6, -1.8, 1.0]]), TICKS)


def test_a_hover_has_the_margins_of_its_distance_alone():
    found = margins(trace(), AROUND)
    assert set(found) == {*MOST, "separation", "zone"} <= set(POLICIES)
    assert found["separation"] == pytest.approx(1.0 / LIMITS.separation - 1.0)
    assert found["zone"] == pytest.approx((1.0 - 0.1) / LIMITS.stray)
    assert all(found[name] >= 1.0 for name in MOST)


@pytest.mark.parametrize("share", [0.99, 1.01])
@pytest.mark.parametrize("known", [True, False])
def test_only_a_push_beyond_the_thrust_exempts_a_vehicle_that_is_away(share: float, known: bool):
    """Off its path from 0.2 s on; pushed at 0.5 s; it has `settle` 0.3 s from there."""
    vehicle, flight = AROUND.vehicle, trace()
    flight.true_pos[20:, 0, 2] -= 2.0 * LIMITS.back
    push = np.zeros((TICKS, 2, 3))
    push[50, 0, 2] = -share * (vehicle.rpyt_thrust_max / vehicle.mass - GRAVITY)
    around = replace(AROUND, limits=replace(LIMITS, settle=0.3, passing=0.01))
    judged = replace(flight, true_downwash=push) if known else flight
    for late, exempt in ((40, False), (55, share > 1.0 and known), (79, share > 1.0 and known), (81, False)):
        only = np.full(TICKS, np.nan)
        only[late] = 0.0  # judged at this tick alone
        one = replace(judged, sent_pos=judged.sent_pos + only[:, None, None])
        found = {each.policy for each in judge(one, around)} & {"return"}
        assert found == (set() if exempt else {"return"})


@pytest.mark.parametrize("share", [0.5, 0.99, 1.01, 3.0])
def test_a_margin_is_linear_in_the_worst_value_and_negative_where_the_policy_is_violated(share: float):
    flight = trace()
    flight.true_pos[50, 0, 1] -= share * LIMITS.state_error_max
    flight.roll[20, 1] = share * LIMITS.tilt_max
    flight.state_age[30, 0] = share * LIMITS.state_age_max
    found = margins(flight, AROUND)
    for name in ("state_error", "tilt", "state_age"):
        assert found[name] == pytest.approx(1.0 - share)
    assert found["setpoint_error"] == pytest.approx(
        1.0 - share * LIMITS.state_error_max / LIMITS.setpoint_error_max
    )
    violated = {one.policy for one in judge(flight, AROUND)}
    assert violated == {name for name, margin in found.items() if margin < 0.0}


def test_vehicles_in_contact_and_in_the_zone_have_negative_margins():
    flight = trace()
    flight.true_pos[40, 0] = flight.true_pos[40, 1] + np.array([0.05, 0.0, 0.0])
    found = margins(flight, AROUND)
    assert found["separation"] == pytest.approx(0.05 / LIMITS.separation - 1.0)
    assert found["zone"] == pytest.approx(-0.05 / LIMITS.stray)


def test_what_is_not_judged_has_an_infinite_margin():
    flight = replace(trace(), state_status=np.full(SHAPE, float(TrackStatus.LOST)))
    assert margins(flight, AROUND)["state_error"] == np.inf
    alone = hovering(np.array([[2.0, -1.0, 1.0]]))
    assert margins(alone, AROUND)["separation"] == margins(alone, AROUND)["zone"] == np.inf
