"""Braking of vehicles without measurements is judged by its deceleration, wherever the motion is known."""

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from resting_signals import level_command, resting_state

from q2q_control.failsafe.tracking_loss.braking_law import BRAKING_MAX, BRAKING_S
from q2q_control.failsafe.tracking_loss.dead_reckoning import OBSERVER
from q2q_model.signals.stamps import TICK_S
from q2q_model.signals.values import CommandStatus, Interference, TrackStatus
from q2q_model.vehicle.constants import GRAVITY
from q2q_sim.campaigns.falsification.counterexample import with_faults
from q2q_sim.campaigns.falsification.postconditions.brake_property import FAST, SHARE, brake
from q2q_sim.campaigns.falsification.postconditions.hidden_motion import learned_push
from q2q_sim.campaigns.falsification.postconditions.run_ticks import RunTicks
from q2q_sim.campaigns.random_runs.random_run import Run, draw_run
from q2q_sim.faults.faults import Fault

LAST, LEVELS, END = 350, 400, 450
"""Ticks in which cf1 is measured last, in which it begins to fly level, and after the flight."""


@cache
def two_vehicles() -> Run:
    """Return a run of cf1 and cf2 without faults."""
    run = next(run for run in map(draw_run, range(100)) if run.scenario.names == ("cf1", "cf2"))
    return with_faults(run, ())


def level_flight(speed: float, deceleration: float) -> RunTicks:
    """Return a flight of cf1 along x, which is lost, and decelerates by command only; cf2 hovers."""
    names, still = ("cf1", "cf2"), np.zeros((2, 3))
    vel = np.array([[speed, 0.0, 0.0], [0.0, 0.0, 0.0]])
    states, commands = [], []
    for k in range(END):
        age = np.array([max(k - LAST, 0) * TICK_S, 0.0])
        lost = np.array([TrackStatus.LOST if k >= LEVELS else TrackStatus.TRACKED, TrackStatus.TRACKED])
        states.append(resting_state(k * TICK_S, names, still, vel=vel, age=age, status=lost.astype(np.uint8)))
        level = np.array([CommandStatus.LEVEL if k >= LEVELS else CommandStatus.OK, CommandStatus.OK])
        pitch = np.array([-math.atan(deceleration / GRAVITY), 0.0])
        flat = np.zeros(2)
        commands.append(level_command(k * TICK_S, names, flat, pitch=pitch, status=level.astype(np.uint8)))
    t = np.array([k * TICK_S for k in range(END)])
    calm = Interference(0.0, names, still, still, np.zeros(2, np.uint8))
    return RunTicks(t, t, names, tuple(states), tuple(states), (), tuple(commands), (calm,) * END)


@pytest.mark.parametrize(("speed", "due"), [(0.5, 0.5 / BRAKING_S), (3.0, BRAKING_MAX)])
@pytest.mark.parametrize("share", [-1.0, 0.0, 0.9 * SHARE, 1.1 * SHARE, 1.0])
def test_a_share_of_the_deceleration_that_is_due_is_required(speed: float, due: float, share: float) -> None:
    found = brake(two_vehicles(), level_flight(speed, share * due))
    assert [one.who for one in found.violations] == (["cf1"] if share < SHARE else [])
    assert all(one.value == pytest.approx(share) for one in found.violations)
    assert found.margin == pytest.approx(min(max(share / SHARE - 1.0, 1.0 - speed / FAST), 1.0))


def test_one_that_speeds_up_once_it_is_measured_again_was_slow_when_it_was_commanded() -> None:
    fast = level_flight(2.0 * FAST, 0.0)
    slow = [
        replace(one, vel=0.1 * one.vel) if LAST < k < END - 22 else one for k, one in enumerate(fast.truth)
    ]  # judged are the commands of LAG_S before the end and earlier
    assert brake(two_vehicles(), fast).violations
    assert not brake(two_vehicles(), replace(fast, truth=tuple(slow))).violations


def test_the_margin_of_a_slow_vehicle_that_is_not_braked_reports_how_slow_it_is() -> None:
    found = brake(two_vehicles(), level_flight(0.3 * FAST, 0.0))
    assert found.violations == ()
    assert found.margin == pytest.approx(0.7)


def test_a_vehicle_that_was_slow_when_it_was_last_measured_is_not_judged() -> None:
    ticks = level_flight(1.0, 0.0)
    rest = replace(ticks.truth[0], vel=np.zeros((2, 3)))
    pushed = replace(ticks, truth=(*(rest for _ in range(LEVELS)), *ticks.truth[LEVELS:]))
    assert brake(two_vehicles(), pushed).violations == ()


SEEN = LAST * TICK_S


@pytest.mark.parametrize(
    ("fault", "judged"),
    [
        (Fault("jump", SEEN - 1.5, 0.3, ("cf1",), 0.3), True),
        (Fault("jump", SEEN - 1.5, 0.7, ("cf1",), 0.3), False),
        (Fault("jump", SEEN - 0.1, 0.7, ("cf2",), 0.3), True),
        (Fault("jump", SEEN + 0.1, 0.7, ("cf1",), 0.3), True),
        (Fault("swap", SEEN - 0.1, 0.1, ("cf1", "cf2")), False),
        (Fault("radio_loss", SEEN + 0.1, 0.7, ("cf1",), 1.0), False),
        (Fault("radio_loss", SEEN - 1.5, 0.2, ("cf1",), 1.0), True),
        (Fault("clock_jump", SEEN + 0.1, 0.7, (), 0.3), False),
        (Fault("clock_jump", SEEN - 1.5, 0.2, (), 0.2), True),
        (Fault("clock_jump", SEEN - 1.5, 0.2, (), 0.4), False),
        (Fault("late", SEEN - 0.1, 0.05, (), 0.1), False),
        (Fault("late", SEEN - 0.3, 0.1, (), 0.1), True),
        (Fault("weak_rotor", SEEN - 3.0, 2.5, ("cf1",), 0.1), False),
        (Fault("weak_rotor", SEEN - 1.5, 5.0, ("cf1",), 0.1), True),
    ],
)
def test_braking_is_judged_unless_a_fault_hides_the_motion(fault: Fault, judged: bool) -> None:
    found = brake(with_faults(two_vehicles(), (fault,)), level_flight(1.0, 0.0))
    assert bool(found.violations) == judged
    assert math.isfinite(found.margin) == judged


@pytest.mark.parametrize(
    ("mode", "begin", "end", "judged"),
    [
        ("ignoring", LAST - 50, LAST + 1, True),
        ("ignoring", LAST - 50, LAST + 2, False),
        ("ignoring", LEVELS, END, False),
        ("aware", LEVELS, END, True),
    ],
)
def test_braking_is_judged_unless_an_ignored_downwash_has_pushed(
    mode: str, begin: int, end: int, judged: bool
) -> None:
    run, ticks = two_vehicles(), level_flight(1.0, 0.0)
    push = replace(ticks.pushes[0], acc=np.array([[0.0, 0.0, -0.2], [0.0, 0.0, 0.0]]))
    pushes = tuple(push if begin <= k < end else calm for k, calm in enumerate(ticks.pushes))
    flown = replace(run, options=replace(run.options, mode=mode))
    assert bool(brake(flown, replace(ticks, pushes=pushes)).violations) == judged


def aware_in(air: str) -> Run:
    """Return the run in an air, by a controller that knows the downwash."""
    run = two_vehicles()
    return replace(run, document={**run.document, "air": air}, options=replace(run.options, mode="aware"))


@pytest.mark.parametrize(
    ("air", "gust", "steady", "judged"),
    [("room", 0.0, 0.5, True), ("room", 0.2, 0.0, True), ("room", 0.5, 0.0, False), ("", 0.5, 0.0, True)],
)
def test_in_another_air_a_vehicle_is_not_judged_that_a_gust_has_blown_by_more_than_can_be_known(
    air: str, gust: float, steady: float, *, judged: bool
) -> None:
    """The gust [m/s^2] begins with the last measurement, half a second before cf1 levels."""
    ticks, run = level_flight(1.0, 0.0), aware_in(air)
    pushed = [
        replace(one, acc=np.array([[steady + (gust if k > LAST else 0.0), 0.0, 0.0], [0.0, 0.0, 0.0]]))
        for k, one in enumerate(ticks.pushes)
    ]
    assert bool(brake(run, replace(ticks, pushes=tuple(pushed))).violations) == judged


@pytest.mark.parametrize(("gust_std", "judged"), [(0.0, True), (1.0, False)])
def test_in_the_scenarios_own_air_its_gusts_hide_a_motion_too(gust_std: float, *, judged: bool) -> None:
    run, ticks = two_vehicles(), level_flight(1.0, 0.0)
    gusty = replace(run, document={**run.document, "disturbance": {"air_std": gust_std}})
    assert bool(brake(gusty, ticks).violations) == judged


def test_a_steady_push_is_learned_as_by_the_observer_of_dead_reckoning() -> None:
    steady = np.tile([0.3, -0.2], (END, 2, 1))
    t = OBSERVER[0] * TICK_S * np.arange(1, END + 1)
    left = 1.0 - (1.0 + t) * np.exp(-t)  # of a unit step through two equal poles
    np.testing.assert_allclose(learned_push(steady)[:, 0, 0], 0.3 * left, atol=4e-3)
    np.testing.assert_allclose(learned_push(steady)[:, 0, 1], -0.2 * left, atol=4e-3)


@pytest.mark.parametrize(("begun", "judged"), [(LEVELS, False), (END, True)])
def test_a_gust_counts_until_the_command_takes_effect(begun: int, *, judged: bool) -> None:
    gust = np.array([[10.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    ticks = level_flight(1.0, 0.0)
    pushed = [replace(one, acc=gust) if k > begun else one for k, one in enumerate(ticks.pushes)]
    assert bool(brake(aware_in("room"), replace(ticks, pushes=tuple(pushed))).violations) == judged


@pytest.mark.parametrize("repeated", [False, True])
def test_a_gust_counts_from_the_last_frame_that_was_not_repeated(*, repeated: bool) -> None:
    """The gust blows for 0.2 s until cf1 is measured last, in frames of one stamp or of their own."""
    ticks, run, begun = level_flight(1.0, 0.0), aware_in("room"), LAST - 20
    gust = np.array([[2.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    pushed = [replace(one, acc=gust) if begun < k <= LAST else one for k, one in enumerate(ticks.pushes)]
    stamp = np.where((ticks.t > ticks.t[begun]) & (ticks.t <= ticks.t[LAST]), ticks.t[begun], ticks.t)
    flown = replace(ticks, pushes=tuple(pushed), stamp=stamp if repeated else ticks.stamp)
    assert bool(brake(run, flown).violations) != repeated


@pytest.mark.parametrize(("aside", "judged"), [(0.2, False), (0.3, True)])
def test_in_another_air_a_vehicle_that_was_below_another_is_not_judged(aside: float, *, judged: bool) -> None:
    """Its wake tilts cf1, which nobody measures."""
    ticks = level_flight(1.0, 0.0)
    above = np.array([[0.0, 0.0, 1.0], [aside, 0.0, 1.5]])
    flown = replace(ticks, truth=tuple(replace(one, pos=above) for one in ticks.truth))
    assert bool(brake(aware_in("room"), flown).violations) == judged
