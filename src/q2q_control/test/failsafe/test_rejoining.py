"""A vehicle measured again far from its setpoint is led back to it smoothly, no faster than tilt allows."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from resting_signals import resting_setpoint, resting_state

from q2q_control.failsafe.evasion.rejoining import ACC_MAX, FAR, JERK_MAX, Rejoining
from q2q_control.inputs.preview import SampledPreview, shifted_preview
from q2q_model.signals.values import Array, SwarmSetpoint, SwarmState

TICK = 0.01
NOBODY: frozenset[str] = frozenset()
GONE = frozenset({"cf1"})
coordinate = st.floats(-3.0, 3.0)
speed = st.floats(-1.0, 1.0)


def state_of(pos: Array, vel: Array) -> SwarmState:
    return resting_state(0.0, ("cf1",), np.array([[*pos, 1.0]]), vel=np.array([[*vel, 0.0]]))


def plan_at(t: float) -> SwarmSetpoint:
    """Return a setpoint that moves on at 0.5 m/s."""
    return resting_setpoint(t, ("cf1",), np.array([[0.5 * t, 0.0, 1.0]]), vel=np.array([[0.5, 0.0, 0.0]]))


def led_back(pos: Array, vel: Array, ticks: int = 600) -> list[SwarmSetpoint]:
    """Return the setpoints of a vehicle that is measured again at pos [m] with vel [m/s], (2,)."""
    led = Rejoining()
    led.update(plan_at(-TICK), state_of(pos, vel), GONE)
    return [led.update(plan_at(k * TICK), state_of(pos, vel), NOBODY) for k in range(ticks)]


@settings(max_examples=50, deadline=None)
@given(x=coordinate, y=coordinate, vx=speed, vy=speed)
def test_it_begins_where_it_is_and_ends_on_the_plan_without_more_than_its_acceleration(
    x: float, y: float, vx: float, vy: float
) -> None:
    made = led_back(np.array([x, y]), np.array([vx, vy]))
    if np.hypot(x, y) <= FAR:
        assert all(np.array_equal(one.pos, plan_at(one.t).pos) for one in made)
        return
    np.testing.assert_allclose(made[0].pos, [[x, y, 1.0]], atol=1e-12)
    away = np.array([x, y]) / np.hypot(x, y)  # the plan begins at the origin
    further = max(float(away @ [vx, vy]), 0.0) * away
    np.testing.assert_allclose(made[0].vel, [[vx - further[0], vy - further[1], 0.0]], atol=1e-12)
    acc = np.array([one.acc[0, :2] for one in made])
    assert np.hypot(*acc.T).max() <= ACC_MAX * (1.0 + 1e-9)
    assert np.hypot(*np.diff(acc, axis=0).T).max() <= JERK_MAX * TICK * (1.0 + 1e-9)
    np.testing.assert_array_equal(made[-1].pos, plan_at(made[-1].t).pos)


def test_at_rest_behind_a_moving_plan_its_setpoint_begins_at_rest_and_is_fastest_on_its_way() -> None:
    made = led_back(np.array([-2.0, 0.0]), np.zeros(2))
    speeds = [float(one.vel[0, 0]) for one in made]
    assert speeds[0] == pytest.approx(0.0, abs=1e-12)  # not the 0.5 m/s of the plan, which would be a step
    assert max(speeds) > 1.5
    assert speeds[-1] == 0.5


@pytest.mark.parametrize(
    ("far", "lasts"),
    [
        (6.0, np.sqrt(10.0 / np.sqrt(3.0) * 6.0 / ACC_MAX)),  # 3.5 s: its peak acceleration is the bound
        (1.0, np.cbrt(60.0 / JERK_MAX)),  # 1.8 s: its first jerk is
    ],
)
def test_from_the_plans_velocity_it_takes_the_least_time_of_a_quintic(far: float, lasts: float) -> None:
    made = led_back(np.array([-far, 0.0]), np.array([0.5, 0.0]))  # as fast as the moving plan
    on_plan = [one.t for one in made if np.array_equal(one.pos, plan_at(one.t).pos)]
    assert on_plan[0] == pytest.approx(lasts, abs=TICK)


def test_the_bounds_are_reached() -> None:
    plan_vel = np.array([0.5, 0.0])
    far = np.array([one.acc[0, 0] for one in led_back(np.array([-6.0, 0.0]), plan_vel)])
    near = np.array([one.acc[0, 0] for one in led_back(np.array([-1.0, 0.0]), plan_vel)])
    assert far.max() == pytest.approx(ACC_MAX, rel=1e-3)
    assert near[1] - near[0] == pytest.approx(JERK_MAX * TICK, rel=0.03)


def test_velocity_and_acceleration_are_those_of_the_motion() -> None:
    made = led_back(np.array([1.5, -0.7]), np.array([-0.3, 0.9]))
    pos, vel, acc = (np.array([getattr(one, of)[0] for one in made]) for of in ("pos", "vel", "acc"))
    np.testing.assert_allclose((pos[2:] - pos[:-2]) / (2.0 * TICK), vel[1:-1], atol=2e-3)
    np.testing.assert_allclose((vel[2:] - vel[:-2]) / (2.0 * TICK), acc[1:-1], atol=0.1)


def test_who_never_was_away_or_is_away_follows_its_setpoint() -> None:
    led, far = Rejoining(), state_of(np.array([2.0, 0.0]), np.zeros(2))
    for away in (NOBODY, GONE, GONE):
        plan = plan_at(0.0)
        assert led.update(plan, far, away) is plan
    assert led.active


def test_lost_again_on_its_way_it_is_led_anew_from_where_it_is_found() -> None:
    led, far = Rejoining(), state_of(np.array([2.0, 0.0]), np.zeros(2))
    led.update(plan_at(0.0), far, GONE)
    led.update(plan_at(0.1), far, NOBODY)
    plan = plan_at(0.5)
    assert led.update(plan, far, GONE) is plan
    nearer = state_of(np.array([1.2, 0.3]), np.zeros(2))
    np.testing.assert_allclose(led.update(plan_at(0.6), nearer, NOBODY).pos, [[1.2, 0.3, 1.0]], atol=1e-12)


def test_a_clock_that_is_set_back_takes_it_no_further_than_to_where_it_began() -> None:
    led, far = Rejoining(), state_of(np.array([2.0, 0.0]), np.zeros(2))
    led.update(plan_at(1.0), far, GONE)
    led.update(plan_at(1.1), far, NOBODY)
    back = led.update(plan_at(0.6), far, NOBODY)
    begun = 2.0 - plan_at(1.1).pos[0, 0]
    np.testing.assert_allclose(back.pos[0, :2], plan_at(0.6).pos[0, :2] + [begun, 0.0], atol=1e-12)


@pytest.mark.parametrize("pos", [np.inf, 1e200])
def test_it_is_not_led_to_where_no_controller_flies(pos: float) -> None:
    led, here = Rejoining(), state_of(np.zeros(2), np.zeros(2))
    led.update(plan_at(0.0), here, GONE)
    plan = replace(plan_at(TICK), pos=np.array([[pos, 0.0, 1.0]]))
    assert led.update(plan, here, NOBODY) is plan


def test_it_is_not_led_by_a_velocity_that_is_no_number() -> None:
    led, here = Rejoining(), state_of(np.array([2.0, 0.0]), np.zeros(2))
    led.update(plan_at(0.0), here, GONE)
    plan = replace(plan_at(TICK), vel=np.array([[np.nan, 0.0, 0.0]]))
    assert led.update(plan, here, NOBODY) is plan


def test_who_leaves_the_setpoints_is_not_led() -> None:
    led, far = Rejoining(), state_of(np.array([2.0, 0.0]), np.zeros(2))
    led.update(plan_at(0.0), far, GONE)
    led.update(plan_at(0.1), far, NOBODY)
    other = replace(plan_at(0.2), names=("cf2",))
    assert led.update(other, far, NOBODY) is other


@pytest.mark.parametrize("planned", [True, False])
def test_a_preview_shows_ahead_the_setpoints_that_it_is_led_along(planned: bool) -> None:
    """Without a plan, the setpoint beside the shift is extrapolated; one at rest stays where it is."""
    rest = replace(plan_at(0.0), vel=np.zeros((1, 3)))
    plan = SampledPreview(
        ("cf1",), 0.0, 10.0, np.repeat(np.array([[[0.0, 0.0, 1.0] + [0.0] * 6]]), 2, axis=1)
    )
    led, far = Rejoining(), state_of(np.array([2.0, -1.0]), np.array([0.3, 0.9]))
    led.update(replace(rest, t=-TICK), far, GONE)
    made = [led.update(replace(rest, t=k * TICK), far, NOBODY) for k in range(400)]
    times = np.array([1.2, 1.6, 2.0, 3.5])
    ahead = shifted_preview(made[100], plan if planned else None, times)[0]
    flown = [made[round(t / TICK)] for t in times]
    np.testing.assert_allclose(ahead[:, :3], [one.pos[0] for one in flown], atol=1e-9)
    np.testing.assert_allclose(ahead[:, 3:6], [one.vel[0] for one in flown], atol=1e-9)
    np.testing.assert_allclose(ahead[:, 6:], [one.acc[0] for one in flown], atol=1e-9)
