"""With bounded jerk and a tube, setpoints keep their bounds whatever the reference does, and pairs apart."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from resting_signals import resting_setpoint, resting_state

from q2q_model.geometry.zone import Cylinder
from q2q_model.signals.some_vehicles import of_vehicles
from q2q_model.signals.values import Array, SetpointStatus, SwarmSetpoint, SwarmState
from q2q_model.trajectory.polynomials import setpoint_at
from q2q_planner.experiments.random_encounters import random_encounter
from q2q_planner.online.safe.motion.safe_replanner_params import SafeReplannerParams
from q2q_planner.online.safe.safe_replanner import SafeReplanner

TICK = 0.01
PARAMS = SafeReplannerParams(
    eps=0.2, acc_max=2.0, jerk_max=20.0, speed_max=2.5, tracking=0.06, tracking_z=0.1
)
TUBES = Cylinder(PARAMS.eps + 2.0 * PARAMS.tracking, PARAMS.d + 2.0 * PARAMS.tracking_z)
BROKEN = SetpointStatus.PROMISE_BROKEN


def reference(t: float, pos: Array, vel: Array, acc: Array) -> SwarmSetpoint:
    n = len(pos)
    names = tuple(f"cf{row}" for row in range(n))
    return resting_setpoint(t, names, pos, vel=vel, acc=acc)


def seen(setpoint: SwarmSetpoint, off: Array) -> SwarmState:
    """Return the state of vehicles that are `off` their setpoints [m], (n, 3)."""
    return resting_state(setpoint.t, setpoint.names, setpoint.pos + off, vel=setpoint.vel)


def accelerations(flown: list[SwarmSetpoint]) -> Array:
    return np.array([one.acc for one in flown])


@pytest.mark.parametrize("seed", range(6))
def test_encounters_keep_zone_and_tubes_apart_by_motions_of_bounded_jerk(seed: int) -> None:
    encounter = random_encounter(np.random.default_rng(seed), most=6, clear_by=TUBES.eps + 0.05)
    start = setpoint_at(encounter.plan, 0.0).pos
    i, j = np.triu_indices(len(start), 1)
    if TUBES.signed_distance(start[i] - start[j]).min() < 0.02:
        pytest.skip("they start within the tubes of each other")
    replanner = SafeReplanner(PARAMS)
    flown = [
        replanner.update(setpoint_at(encounter.plan, k * TICK), None)
        for k in range(round((encounter.plan.duration + 1.0) / TICK))
    ]
    pos = np.array([one.pos for one in flown])
    assert TUBES.signed_distance(pos[:, i] - pos[:, j]).min() > 0.0
    assert not any((one.status == BROKEN).any() for one in flown)
    acc = accelerations(flown)
    assert np.abs(acc).max() <= PARAMS.acc_max * (1.0 + 1e-9)
    assert np.abs(np.diff(acc, axis=0)).max() <= PARAMS.jerk_max * TICK * (1.0 + 1e-9)


def test_a_reference_at_30_m_per_s2_is_left_and_followed_within_the_bounds() -> None:
    """It jumps to 30 m/s^2 for 0.1 s, which the replanner without bounded jerk passes on."""
    replanner, flown = SafeReplanner(PARAMS), []
    pos, vel = np.array([[0.0, 0.0, 1.0]]), np.zeros((1, 3))
    for k in range(400):
        acc = np.array([[30.0 if 50 <= k < 55 else -30.0 if 55 <= k < 60 else 0.0, 0.0, 0.0]])
        flown.append(replanner.update(reference(k * TICK, pos, vel, acc), None))
        pos, vel = pos + TICK * vel + 0.5 * TICK**2 * acc, vel + TICK * acc
    moved = accelerations(flown)
    assert np.abs(moved).max() <= PARAMS.acc_max * (1.0 + 1e-9)
    assert np.abs(np.diff(moved, axis=0)).max() <= PARAMS.jerk_max * TICK * (1.0 + 1e-9)
    assert flown[60].status[0] == SetpointStatus.SHIFTED  # announced: it is not where it was asked to be
    assert np.abs(flown[-1].pos - pos).max() < 0.02


@pytest.mark.parametrize("tick", [0.005, 0.01, 0.02])
@pytest.mark.parametrize(("share", "followed"), [(0.95, True), (1.05, False)])
def test_a_reference_is_followed_bit_for_bit_up_to_the_largest_jerk_at_any_rate(
    tick: float, share: float, followed: bool
) -> None:
    peak = 1.8
    rate = share * PARAMS.jerk_max / peak  # of a sine whose jerk is largest at t = 0
    replanner, kept, moved = SafeReplanner(PARAMS), [], []
    for k in range(100):
        x = np.sin(rate * k * tick) * peak * np.array([[-1.0 / rate**2, 0.0, 0.0], [1.0, 0.0, 0.0]])
        vel = np.array([[-np.cos(rate * k * tick) * peak / rate, 0.0, 0.0]])
        asked = reference(k * tick, x[:1], vel, x[1:])
        answer = replanner.update(asked, None)
        kept.append(answer is asked)
        moved.append(answer)
    assert all(kept) == followed
    # one that returns to its reference takes on its acceleration, too
    jumps = np.abs(np.diff(accelerations(moved), axis=0))
    assert jumps.max() <= 2.0 * PARAMS.jerk_max * tick * (1.0 + 1e-9)


@pytest.mark.parametrize(("share", "followed"), [(0.95, True), (1.05, False)])
@pytest.mark.parametrize("holds", [(0.1, 0.02), (0.02, 0.1)])
def test_a_reference_is_followed_up_to_the_largest_jerk_while_hold_changes(
    holds: tuple[float, float], share: float, followed: bool
) -> None:
    replanner, kept = SafeReplanner(replace(PARAMS, hold=holds[0])), []
    pos, vel, acc = np.array([[0.0, 0.0, 1.0]]), np.zeros((1, 3)), np.zeros((1, 3))
    for k, part in enumerate((0.5, -0.5, 0.5, share)):  # of the largest jerk, since the tick before
        if k == 3:
            replanner.configure(replace(PARAMS, hold=holds[1]))
        acc = acc + np.array([[part * PARAMS.jerk_max * TICK, 0.0, 0.0]])
        asked = reference(k * TICK, pos, vel, acc)
        kept.append(replanner.update(asked, None) is asked)
    assert kept == [True, True, True, followed]


@pytest.mark.parametrize(("hold", "tick"), [(0.06, 0.01), (0.1, 0.05), (0.2, 0.1)])
def test_a_step_keeps_the_largest_acceleration_when_ticks_are_slow_or_lost(hold: float, tick: float) -> None:
    params, pos, still = (
        replace(PARAMS, hold=hold, jerk_max=100.0),
        np.array([[0.0, 0.0, 1.0]]),
        np.zeros((1, 3)),
    )
    beyond = pos + np.array([[2.0, 0.0, 0.0]])
    for lost in range(12):  # from this tick on, as many as `hold` covers
        replanner, flown = SafeReplanner(params), [pos[0]]
        for k in range(round(4.0 / tick)):
            if not lost < k < lost + round(hold / tick):
                asked = reference(k * tick, pos if k == 0 else beyond, still, still)
                answer = replanner.update(asked, None)
                flown.append(answer.pos[0])
                assert np.abs(answer.acc).max() <= PARAMS.acc_max * (1.0 + 1e-9)
        assert np.abs(flown[-1] - beyond).max() < 0.1  # it goes there


@pytest.mark.parametrize(
    ("hold", "approach", "jerk", "step"),
    [
        (0.02, 20.0, 20.0, 0.3),
        (0.2, 4.0, 20.0, 2.0),
        (0.5, 2.0, 20.0, 2.0),
        (0.5, 4.0, 100.0, 2.0),
        (0.02, 2.0, 3.0, 2.0),
        (0.2, 20.0, 3.0, 2.0),
    ],
)
def test_a_step_ends_without_overshoot_or_swing_at_any_hold_approach_and_jerk(
    hold: float, approach: float, jerk: float, step: float
) -> None:
    replanner = SafeReplanner(replace(PARAMS, hold=hold, approach=approach, jerk_max=jerk))
    pos, still = np.array([[0.0, 0.0, 1.0]]), np.zeros((1, 3))
    beyond = pos + np.array([[step, 0.0, 0.0]])
    beside = np.array(
        [
            replanner.update(reference(k * TICK, beyond if k else pos, still, still), None).pos[0] - beyond[0]
            for k in range(1200)
        ]
    )
    assert beside[:, 0].max() <= 1e-3
    assert np.abs(beside[-1]).max() <= 0.01


def test_a_tube_is_as_wide_and_as_high_as_it_says() -> None:
    pos, still = np.array([[0.0, 0.0, 1.0], [9.0, 0.0, 1.0]]), np.zeros((2, 3))
    for axis, most in ((0, PARAMS.tracking), (2, PARAMS.tracking_z)):
        for share, expected in ((0.99, False), (1.01, True)):
            off = np.zeros((2, 3))
            off[0, axis] = share * most
            replanner, start = SafeReplanner(PARAMS), reference(0.0, pos, still, still)
            replanner.update(start, seen(start, 0.0 * off))
            setpoint = replace(start, t=TICK)
            broken = replanner.update(setpoint, seen(setpoint, off)).status == BROKEN
            assert broken.tolist() == [expected, False]


@pytest.mark.parametrize("late", [False, True])
@pytest.mark.parametrize(("vel", "acc"), [(0.0, 8.0), (0.0, 30.0), (4.0, 0.0), (2.5, 2.1), (2.6, 2.0)])
@pytest.mark.parametrize("along", [(1.0, 0.0, 0.0), (2.0 / 3.0, 2.0 / 3.0, 1.0 / 3.0)])
def test_a_first_setpoint_beyond_the_bounds_is_left_within_them(
    vel: float, acc: float, along: tuple[float, float, float], late: bool
) -> None:
    """Of a whole swarm, or of one vehicle that joins it."""
    pos, still = np.array([[0.0, 0.0, 1.0], [0.0, 9.0, 1.0]]), np.zeros((2, 3))
    replanner, hover, first = SafeReplanner(PARAMS), reference(0.0, pos, still, still), np.zeros((2, 2, 3))
    if late:
        replanner.update(of_vehicles(hover, np.array([1])), None)
    first[:, 0] = np.multiply.outer((vel, acc), along)
    asked = [replace(hover, t=TICK, vel=first[0], acc=first[1])]
    asked += [replace(hover, t=k * TICK) for k in range(2, 300)]
    flown = [replanner.update(one, None) for one in asked]
    assert accelerations(flown)[0].tolist() == still.tolist()
    assert np.abs(accelerations(flown)).max() <= PARAMS.acc_max * (1.0 + 1e-9)
    assert np.linalg.norm([one.vel for one in flown], axis=-1).max() <= PARAMS.speed_max
    assert not any((one.status == BROKEN).any() for one in flown)
    assert all(one.status[1] == SetpointStatus.NOMINAL for one in flown)


def test_who_is_faster_than_the_tube_was_learned_for_says_so() -> None:
    """A bound that is lowered in flight is broken until the vehicle has slowed down."""
    start, vel, still = np.array([[0.0, 0.0, 1.0]]), np.array([[2.4, 0.0, 0.0]]), np.zeros((1, 3))
    replanner, flown = SafeReplanner(PARAMS), []
    for k in range(300):
        if k == 10:
            replanner.configure(replace(PARAMS, speed_max=2.0))
        flown.append(replanner.update(reference(k * TICK, start + k * TICK * vel, vel, still), None))
    fast = [bool(np.linalg.norm(one.vel) > 2.0) for one in flown]
    assert [(one.status == BROKEN).all() for one in flown] == [False] * 10 + fast[10:]
    assert fast[10]
    assert not any(fast[100:])
    assert flown[-1].status[0] == SetpointStatus.SHIFTED


@pytest.mark.parametrize(("top", "acc"), [(2.52, 0.3), (2.52, 1.99), (3.0, 1.0), (4.0, 1.99)])
@pytest.mark.parametrize("along", [(1.0, 0.0, 0.0), (0.6, -0.48, 0.64)])
def test_a_reference_faster_than_the_largest_speed_is_left_and_followed_below_it(
    top: float, acc: float, along: tuple[float, float, float]
) -> None:
    """It speeds up within the bounds of jerk and acceleration, flies on, and stops at once after 4 s."""
    replanner, direction, flown = SafeReplanner(PARAMS), np.array([along]), []
    for k, (x, speed, a) in enumerate(_speeding(top, acc)):
        asked = reference(k * TICK, x * direction, speed * direction, a * direction)
        flown.append(replanner.update(asked, None))
    fastest = np.linalg.norm([one.vel for one in flown], axis=-1).max()
    assert 0.95 * PARAMS.speed_max - 0.02 < fastest <= PARAMS.speed_max
    assert not any((one.status == BROKEN).any() for one in flown)
    assert any(one.status[0] == SetpointStatus.SHIFTED for one in flown)
    np.testing.assert_allclose(flown[-1].pos, asked.pos, atol=5e-3)


def _speeding(top: float, acc: float) -> Iterator[tuple[float, float, float]]:
    """Yield place, speed and acceleration of each tick [m, m/s, m/s^2]."""
    x, speed, a = 0.0, 1.5, 0.0
    for k in range(1000):
        yield (x, speed, a) if k < 400 else (x, 0.0, 0.0)
        if k < 400:
            desired = acc if speed + 0.5 * a * a / PARAMS.jerk_max < top else 0.0
            jerk = np.clip((desired - a) / TICK, -PARAMS.jerk_max, PARAMS.jerk_max)
            x += TICK * (speed + TICK * (a / 2.0 + TICK * jerk / 6.0))
            speed, a = speed + TICK * (a + 0.5 * TICK * jerk), a + TICK * jerk


def test_a_reference_whose_acceleration_ends_at_once_below_the_largest_speed_leads_nobody_beyond_it() -> None:
    """It is never faster than 2.48 m/s; a vehicle with its acceleration, of bounded jerk, would be."""
    replanner, flown, ahead = SafeReplanner(PARAMS), [], np.array([[1.0, 0.0, 0.0]])
    x, speed = 0.0, 1.0
    for k in range(300):
        acc = 1.99 if speed < 2.46 else 0.0
        flown.append(replanner.update(reference(k * TICK, x * ahead, speed * ahead, acc * ahead), None))
        x, speed = x + TICK * (speed + 0.5 * TICK * acc), speed + TICK * acc
    assert 2.46 < speed < 2.48
    assert max(np.linalg.norm(one.vel) for one in flown) <= PARAMS.speed_max
    assert not any((one.status == BROKEN).any() for one in flown)


@pytest.mark.parametrize(("start", "jump", "acc"), [(0.5, 3.0, 1.9), (1.5, 1.0, 1.0)])
def test_a_reference_that_speeds_up_on_the_way_back_to_it_leads_nobody_beyond_the_largest_speed(
    start: float, jump: float, acc: float
) -> None:
    """It stays below the largest speed itself, and jumps ahead once."""
    replanner, flown, ahead = SafeReplanner(PARAMS), [], np.array([[1.0, 0.0, 0.0]])
    x, speed = 0.0, start
    for k in range(500):
        x, a = x + jump * (k == 50), acc * (k >= 110 and speed < 2.3)
        flown.append(replanner.update(reference(k * TICK, x * ahead, speed * ahead, a * ahead), None))
        x, speed = x + TICK * (speed + 0.5 * TICK * a), speed + TICK * a
    assert max(np.linalg.norm(one.vel) for one in flown) <= PARAMS.speed_max
    assert not any((one.status == BROKEN).any() for one in flown)


def test_an_external_vehicle_nearby_is_outside_the_conditions() -> None:
    pos, still = np.array([[0.0, 0.0, 1.0]]), np.zeros((1, 3))
    setpoint = reference(0.0, pos, still, still)
    for x, expected in ((1.0, True), (30.0, False)):
        near = replace(seen(setpoint, np.array([[x, 0.0, 0.0]])), names=("stranger",))
        assert (SafeReplanner(PARAMS).update(setpoint, near).status == BROKEN).all() == expected
