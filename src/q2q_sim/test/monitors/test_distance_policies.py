"""Policies of where vehicles are: apart, out of zones, near their setpoints and off the floor."""

from dataclasses import replace

import numpy as np
import pytest
from changed_flights import AROUND, SCENARIO, Change, broken, changed, only, received, with_row
from hovering_trace import hovering

from q2q_model.signals.values import (
    CommandStatus,
    Interference,
    MocapFrame,
    SwarmCommand,
    SwarmSetpoint,
    SwarmState,
    TrackStatus,
)
from q2q_model.vehicle.constants import GRAVITY
from q2q_sim.faults.faults import Fault
from q2q_sim.monitors.policies import (
    Circumstances,
    FlightTrace,
    judge,
    trace_of,
)
from q2q_sim.monitors.policies.floor import floor
from q2q_sim.tools.judge_bags import judge_bag


def test_two_vehicles_that_touch_break_the_separation_and_who_strays_the_room() -> None:
    at = received()[0].signal
    assert isinstance(at, SwarmState)
    near = only(
        "truth", changed(SwarmState, 3.0, 3.1, pos=with_row(0, at.pos[1] + np.array([0.0, 0.10, 0.0])))
    )
    assert {"separation", "setpoint_error"} <= broken(near)
    apart = only(
        "truth", changed(SwarmState, 3.0, 3.1, pos=with_row(0, at.pos[1] + np.array([0.0, 0.20, 0.0])))
    )
    assert "separation" not in broken(apart)
    for size, touch in ((0.01, True), (0.05, False)):  # beside the distance, of 0.14 m
        displaced = Fault("jump", 2.9, 0.3, (at.names[0],), size)
        assert ("separation" in broken(near, replace(AROUND, faults=(displaced,)))) == touch


@pytest.mark.parametrize(
    ("off", "strays"), [((0.0, 0.0, -1.6), False), ((0.0, 0.0, 1.6), True), ((1.6, 0.0, -0.1), True)]
)
def test_a_vehicle_that_lands_unmeasured_is_sent_down_and_nowhere_else(
    off: tuple[float, float, float], strays: bool
) -> None:
    away = only("truth", changed(SwarmState, 3.0, 3.1, pos=lambda pos: pos + np.array(off)))
    lands = changed(SwarmCommand, 2.0, 3.05, status=lambda _: np.full(3, CommandStatus.LAND))
    assert "setpoint_error" in broken(away)
    assert ("setpoint_error" in broken(lambda one: lands(away(one)))) == strays


def test_a_vehicle_whose_marker_is_moved_may_be_so_much_farther() -> None:
    away = only("truth", changed(SwarmState, 3.0, 3.1, pos=lambda pos: pos + np.array([1.8, 0.0, 0.0])))

    def around(size: float, start: float = 2.9) -> Circumstances:
        return replace(
            AROUND, faults=(Fault("jump", start, 0.3, vehicles=received()[0].signal.names, size=size),)
        )

    assert "setpoint_error" in broken(away, around(0.2))
    assert "setpoint_error" not in broken(away, around(-0.4))
    earlier = around(-0.4, start=1.6)
    assert "setpoint_error" in broken(away, earlier)  # moved back 1.1 s before

    def after_missing(until: float) -> set[str]:
        gone = changed(MocapFrame, 1.85, until, pos=lambda pos: np.full_like(pos, np.nan))
        return broken(lambda one: gone(away(one)), earlier)

    assert "setpoint_error" not in after_missing(2.15)  # where it was believed until then
    assert "setpoint_error" in after_missing(2.05)


def test_a_vehicle_in_the_zone_breaks_it_only_where_it_was_sent_clear_of_it() -> None:
    at = received()[0].signal
    assert isinstance(at, SwarmState)
    below = at.pos[1] - np.array([0.0, 0.0, 0.6])
    stray = only("truth", changed(SwarmState, 3.0, 3.1, pos=with_row(0, below)))
    assert "zone" in broken(stray)
    sent = changed(SwarmSetpoint, 3.0, 3.1, pos=with_row(0, below))
    assert "zone" not in broken(lambda one: sent(stray(one)))


def test_without_truth_a_vehicle_that_is_lost_is_nowhere() -> None:
    def without_truth(status: TrackStatus) -> set[str]:
        kept = [one for one in received() if not one.topic.startswith("truth")]
        at_origin = changed(
            SwarmState, 0.0, 0.3, pos=np.zeros_like, status=lambda was: np.full_like(was, status)
        )
        return {one.policy for one in judge_bag(trace_of(map(at_origin, kept)), AROUND).violations}

    assert {"separation", "setpoint_error", "floor"} <= without_truth(TrackStatus.COASTING)
    assert without_truth(TrackStatus.LOST) == set()


def test_who_is_on_the_floor_though_sent_above_it_has_fallen_unless_it_lands_unmeasured() -> None:
    fall = only("truth", changed(SwarmState, 3.0, 3.1, pos=lambda pos: pos * [1.0, 1.0, 0.0]))
    low = changed(SwarmSetpoint, 3.0, 3.1, pos=lambda pos: pos * [1.0, 1.0, 0.0])
    lands = changed(SwarmCommand, 2.0, 3.05, status=lambda _: np.full(3, CommandStatus.LAND))
    assert "floor" in broken(fall)
    assert "floor" not in broken(lambda one: low(fall(one)))
    assert "floor" not in broken(lambda one: lands(fall(one)))


def test_who_is_pushed_down_by_more_than_it_can_hold_is_not_judged_for_it() -> None:
    """The largest thrust, less what faults take, holds a downwash up to a known one: more or less."""
    vehicle = SCENARIO.vehicle
    fall = only("truth", changed(SwarmState, 3.0, 3.1, pos=lambda pos: pos * [1.0, 1.0, 0.0]))

    def pushed(by: float) -> Change:
        downwash = changed(Interference, 2.0, 3.05, acc=lambda acc: np.full_like(acc, [0.0, 0.0, -by]))
        return lambda one: only("truth_interference", downwash)(fall(one))

    sag = Fault("battery_sag", 0.0, 1.0, (), 0.1)
    weak = Fault("weak_rotor", 2.0, 2.0, (), 0.2)
    gone = Fault("weak_rotor", 1.0, 0.5, (), 0.2)
    for faults, left in (((), 1.0), ((sag,), 0.9), ((sag, weak), 0.9 * 0.95), ((gone,), 1.0)):
        around = replace(AROUND, faults=faults)
        held = left * vehicle.rpyt_thrust_max / vehicle.mass - GRAVITY
        assert {"floor"} <= broken(pushed(held - 0.01), around)
        assert not {"floor", "setpoint_error", "zone", "return"} & broken(pushed(held + 0.01), around)
    named = replace(AROUND, faults=(replace(sag, vehicles=("cf2", "cf3")),))
    assert "floor" in broken(pushed(0.95 * vehicle.rpyt_thrust_max / vehicle.mass - GRAVITY), named)


def test_setpoints_that_a_replanner_leads_into_the_floor_excuse_no_fall() -> None:
    """A plan from the floor excuses it, as does one that jumps while the vehicle still stands there."""
    flight = hovering(np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 1.0]]))
    flight.true_pos[50:, 0, 2] = flight.sent_pos[50:, 0, 2] = 0.0
    limits = AROUND.limits

    def fallen(trace: FlightTrace) -> list[tuple[str, float]]:
        return [(one.who, one.t) for one in judge(trace, AROUND, {"floor": floor})]

    assert fallen(flight) == [("cf1", pytest.approx(0.5))]
    lands = flight.asked_pos.copy()
    lands[45:60, 0, 2] = 0.5 * limits.take_off
    assert fallen(replace(flight, asked_pos=lands)) == []
    takes_off = replace(flight, true_pos=flight.true_pos.copy(), sent_pos=flight.sent_pos.copy())
    takes_off.true_pos[:, 0, 2] = takes_off.sent_pos[:, 0, 2] = 0.0
    assert fallen(takes_off) == []
