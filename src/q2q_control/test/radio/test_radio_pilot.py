"""What goes over the radio, and when: words of cflib, refusals, landings, lost links, places."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from radio_pilot_bench import LANDING_S, NAMES, PARAMS, WELL, Bench, state

from q2q_control.flight_procedure.procedure_params import LandingParams
from q2q_control.flight_procedure.steps import Act, Order
from q2q_control.radio.link.setpoints import (
    ZERO_RPYT,
    RpytSetpoint,
)
from q2q_control.radio.link.vehicle_link import CflibSender
from q2q_control.radio.pilot.vehicle_record import Phase
from q2q_control.radio.radio_executor import RadioExecutor
from q2q_model.node.reply import Reply
from q2q_model.signals.values import (
    SwarmState,
    TrackStatus,
)
from q2q_model.vehicle.constants import CRAZYFLIE_2_0, GRAVITY
from q2q_model.vehicle.hover_thrust import OwnHover, hover_pwm


def test_arming_unlocks_and_only_streamed_vehicles_are_sent_commands() -> None:
    bench = Bench()
    bench.rpyt_setpoints()
    assert bench.done(Act.ARM).granted
    bench.rpyt_setpoints()
    assert bench.done(Act.TAKE_OFF).granted
    bench.rpyt_setpoints()
    assert set(bench.pilot.phases.values()) == {Phase.CLIMBING}
    bench.done(Act.STREAM)
    bench.rpyt_setpoints()
    assert bench.links["cf2"].sent == [
        "arm",
        ZERO_RPYT,
        ("take off", 0.5, 2.0),
        RpytSetpoint(1.0, 2.0, 3.0, 30000),
    ]


def test_a_vehicle_that_does_not_arm_in_time_is_named() -> None:
    bench = Bench()
    bench.links["cf1"].now = replace(WELL, armed=False)
    bench.pilot.begin(Order(Act.ARM), bench.t)
    bench.pilot.watch(bench.t + 1.9)
    assert bench.pilot.outcome(bench.t + 1.9) is None
    bench.pilot.watch(bench.t + 2.1)
    assert bench.pilot.outcome(bench.t + 2.1) == Reply(granted=False, reason="cf1 did not arm within 2 s")
    assert bench.pilot.outcome(bench.t + 2.1) is None  # reported once


def test_disarming_is_done_when_no_vehicle_is_armed_and_says_who_arms_itself() -> None:
    bench = Bench()
    bench.done(Act.ARM)
    bench.pilot.begin(Order(Act.DISARM), bench.t)
    assert bench.pilot.outcome(bench.t + 1.9) is None
    bench.links["cf1"].now = replace(WELL, armed=False)
    reply = bench.pilot.outcome(bench.t + 2.1)
    assert reply == Reply(granted=False, reason="cf2 armed again: their firmware arms itself")
    assert [link.sent[-1] for link in bench.links.values()] == ["disarm", "disarm"]


def test_a_pilot_as_crew_reports_what_its_links_and_phases_say() -> None:
    bench = Bench()
    bench.fly()
    own = OwnHover(mass=0.03, mass_thrust=hover_pwm(CRAZYFLIE_2_0) / (1.1 * 0.03 * GRAVITY))
    bench.links["cf2"].now = replace(
        WELL, volt=3.3, onboard=(1.0, 2.0, 3.0), wrong="mass is 0", own_hover=own, flying=False
    )
    first, second = RadioExecutor(bench.pilot, bench.links, CRAZYFLIE_2_0).reports()
    assert (first.name, first.connected, first.armed, first.flies) == ("cf1", True, True, True)
    assert (second.volt, second.onboard, second.wrong) == (3.3, (1.0, 2.0, 3.0), "mass is 0")
    assert (first.airborne, second.airborne) == (True, False)
    assert second.hover_ratio == pytest.approx(1.1)
    assert math.isnan(first.hover_ratio)


def test_a_low_battery_lands_its_vehicle_after_a_while_whatever_is_commanded() -> None:
    bench = Bench()
    bench.fly()
    bench.links["cf2"].now = replace(WELL, volt=3.1)
    bench.pilot.watch(bench.t)
    bench.links["cf2"].now = WELL  # a dip under load is forgiven
    bench.pilot.watch(bench.t + 1.0)
    bench.links["cf2"].now = replace(WELL, volt=3.1)
    bench.pilot.watch(bench.t + 1.5)
    bench.pilot.watch(bench.t + 3.4)
    assert bench.pilot.phases["cf2"] is Phase.FLYING
    bench.pilot.watch(bench.t + 3.5)
    assert bench.pilot.phases == {"cf1": Phase.FLYING, "cf2": Phase.LANDING}
    bench.rpyt_setpoints()
    assert bench.links["cf2"].sent[-1] == ("land", 0.0, LANDING_S[1])
    bench.pilot.watch(bench.t + 3.5 + LANDING_S[1] - 0.1)
    assert bench.pilot.phases["cf2"] is Phase.LANDING
    bench.pilot.watch(bench.t + 3.5 + LANDING_S[1] + 0.1)
    assert bench.pilot.phases["cf2"] is Phase.READY


def test_a_landing_takes_as_long_as_the_height_asks_for_and_no_less_than_land_s() -> None:
    bench = Bench()
    bench.fly()
    low = state(bench.t)
    low.pos[:, 2] = [0.5, 2.0]
    bench.pilot.update_state(low, bench.t)
    bench.pilot.land(bench.t)
    least = LandingParams().landing_duration_min
    assert [bench.links[name].sent[-1] for name in NAMES] == [("land", 0.0, least), ("land", 0.0, 2.0 / 0.4)]
    assert bench.pilot.landing_left(bench.t) == 2.0 / 0.4


@pytest.mark.parametrize("ground_height", [0.8, -0.8])
def test_vehicles_land_to_the_ground_in_a_duration_by_the_height_above_it(ground_height: float) -> None:
    bench = Bench(ground_height=ground_height)
    bench.fly()
    bench.links["cf1"].now = replace(WELL, volt=3.1)
    for later in (0.0, PARAMS.voltage_land_s):
        bench.look(later)  # cf1 lands by itself
    assert bench.pilot.phases == {"cf1": Phase.LANDING, "cf2": Phase.FLYING}
    bench.done(Act.LAND)
    assert bench.links["cf1"].sent[-1] == ("land", ground_height, pytest.approx((3.0 - ground_height) / 0.4))
    assert bench.links["cf2"].sent[-1] == ("land", ground_height, pytest.approx((6.0 - ground_height) / 0.4))


def test_a_landing_over_cflib_stops_setpoints_then_aims_at_its_height() -> None:
    calls: list[tuple[object, ...]] = []
    commander = SimpleNamespace(send_notify_setpoint_stop=lambda: calls.append(("notify",)))
    high_level = SimpleNamespace(land=lambda *given: calls.append(given))
    CflibSender(commander, high_level, SimpleNamespace(), SimpleNamespace()).land(0.8, 3.5)
    assert calls == [("notify",), (0.8, 3.5)]


def test_a_battery_that_is_unknown_lands_nobody() -> None:
    bench = Bench()
    for link in bench.links.values():
        link.now = replace(WELL, volt=math.nan)
    bench.fly()
    bench.pilot.watch(bench.t + 100.0)
    assert set(bench.pilot.phases.values()) == {Phase.FLYING}


def test_land_lands_those_who_fly_and_stop_stops_all() -> None:
    bench = Bench()
    assert not bench.pilot.land(bench.t)
    bench.fly()
    assert bench.pilot.land(bench.t)
    assert set(bench.pilot.phases.values()) == {Phase.LANDING}
    bench.pilot.cut_all(bench.t)
    assert all(link.sent[-1] == "cut" for link in bench.links.values())
    bench.rpyt_setpoints()
    assert all(link.sent[-1] == "cut" for link in bench.links.values())


def test_a_vehicle_commanded_cut_is_logged_and_reported_as_cut_until_it_is_armed_again() -> None:
    bench = Bench()
    bench.fly()
    bench.pilot.log_lines()
    bench.pilot.cut(("cf2",), bench.t)
    bench.pilot.cut(("cf2",), bench.t)
    assert bench.pilot.log_lines() == ["cf2 received CUT: motors stopped", "cf2 is ready"]
    reports = RadioExecutor(bench.pilot, bench.links, CRAZYFLIE_2_0).reports()
    assert [one.cut for one in reports] == [False, True]
    bench.done(Act.ARM)
    assert bench.pilot.motors_cut == frozenset()


def test_places_are_sent_once_a_frame_and_only_where_measured() -> None:
    bench = Bench()
    for t in (1.0, 1.0, 1.01):
        bench.pilot.update_state(turned(t), bench.t)
    bench.pilot.update_state(turned(1.02, TrackStatus.COASTING), bench.t)
    expected = ("place", (4.0, 5.0, 6.0), (0.0, 0.6, 0.0, 0.8))
    assert bench.links["cf2"].sent == [expected, expected]


def test_the_position_alone_is_sent_where_no_attitude_was_ever_measured() -> None:
    bench, one = Bench(), turned(1.0)
    one.quat[0] = [0.0, 0.0, 0.0, 1.0]
    bench.pilot.update_state(one, bench.t)
    assert bench.links["cf1"].sent == [("place", (1.0, 2.0, 3.0), None)]
    assert bench.links["cf2"].sent == [("place", (4.0, 5.0, 6.0), (0.0, 0.6, 0.0, 0.8))]


def turned(t: float, status: TrackStatus = TrackStatus.TRACKED) -> SwarmState:
    """Return a state with measured attitudes."""
    return replace(state(t, status), quat=np.tile([0.0, 0.6, 0.0, 0.8], (2, 1)))


def test_places_are_moved_on_by_their_delay() -> None:
    bench, seen = Bench(), state(1.0)
    turning = replace(seen, vel=seen.pos / 4.0, ang_vel_body=np.tile([0.0, 0.0, 5.0], (2, 1)))
    bench.pilot.update_state(turning, bench.t)
    ((_, pos, quat),) = bench.links["cf2"].sent
    delay = PARAMS.pose_delay_s
    assert pos == pytest.approx([4.0 + delay, 5.0 + 1.25 * delay, 6.0 + 1.5 * delay])
    assert quat == pytest.approx([0.0, 0.0, math.sin(2.5 * delay), math.cos(2.5 * delay)])


def test_a_place_that_is_no_number_and_a_stranger_are_passed_over() -> None:
    bench = Bench()
    one = state(1.0)
    one.pos[0, 1] = np.nan
    bench.pilot.update_state(replace(one, names=("cf1", "stranger")), bench.t)
    assert bench.links["cf1"].sent == bench.links["cf2"].sent == []
