"""Single ticks of the safe law in closed form, and its old motions against a stranger seen late."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from resting_signals import resting_setpoint, resting_state

from q2q_model.signals.values import Array, Names, SetpointStatus, SwarmSetpoint, SwarmState
from q2q_planner.online.safe import safe_replanner
from q2q_planner.online.safe.choice.candidate_motions import PairedTraffic
from q2q_planner.online.safe.choice.desired_motion import FLOOR, DesiredMotion
from q2q_planner.online.safe.choice.motion_choice import ChoiceRule, Choices, Proven, choices_at
from q2q_planner.online.safe.motion.committed_motion import MotionRows
from q2q_planner.online.safe.motion.followed_reference import SNAP_POS, SNAP_VEL
from q2q_planner.online.safe.motion.safe_replanner_params import SafeReplannerParams
from q2q_planner.online.safe.safe_replanner import SafeReplanner

TICK = 0.01
PARAMS = SafeReplannerParams(eps=0.2, d=1.0, tracking=0.02, acc_max=3.0, hold=0.02, forget=0.6)
SOFT = replace(PARAMS, approach=1.5)
"""So that a pole squared is not twice the pole."""
PAIR: Names = ("cf1", "cf2")
BROKEN = SetpointStatus.PROMISE_BROKEN


def setpoint(t: float, names: Names, pos: Array, vel: Array, acc: Array | None = None) -> SwarmSetpoint:
    n = len(names)
    acc = np.zeros((n, 3)) if acc is None else acc
    return resting_setpoint(t, names, pos, vel=vel, acc=acc)


def closing(apart: float, speed: float, acc: Array | None = None) -> SwarmSetpoint:
    """Return two references that come head on along x, each at a speed [m/s]."""
    vel = np.array([[speed, 0.0, 0.0], [-speed, 0.0, 0.0]])
    return setpoint(0.0, PAIR, np.array([[0.0, 0.0, 1.0], [apart, 0.0, 1.0]]), vel, acc)


def asked(apart: float, speed: float) -> float:
    """Return the relative acceleration that the barrier asks of a pair head on [m/s^2]."""
    wide = PARAMS.eps + PARAMS.margin + FLOOR + 2.0 * (PARAMS.tracking + SNAP_POS)
    pole = SOFT.approach
    return 2.0 * pole * (2.0 * speed + 2.0 * SNAP_VEL) - pole**2 * (apart - wide)


@pytest.mark.parametrize("speed", [0.5, 0.6])
def test_a_pair_head_on_shares_what_the_barrier_asks(speed: float) -> None:
    need = asked(1.0, speed)
    assert 0.0 < need < 2.0 * PARAMS.acc_max
    answer = SafeReplanner(SOFT).update(closing(1.0, speed), None)
    np.testing.assert_allclose(
        answer.acc, [[-need / 2.0, 0.0, 0.0], [need / 2.0, 0.0, 0.0]], rtol=1e-12, atol=1e-12
    )
    assert answer.status.tolist() == [SetpointStatus.NOMINAL] * 2  # not moved yet


@pytest.mark.parametrize("tick", [0.005, 0.01, 0.02, 0.04])
def test_the_vehicles_of_a_pair_take_turns_at_any_rate_of_ticks(
    tick: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    turns = []

    def recorded(
        rows: MotionRows, desired: DesiredMotion, traffic: PairedTraffic, proven: Proven, rule: ChoiceRule
    ) -> Choices:
        turns.append(rule.turn)
        return choices_at(rows, desired, traffic, proven, rule)

    monkeypatch.setattr(safe_replanner, "choices_at", recorded)
    replanner = SafeReplanner(PARAMS)
    for k in range(3, 9):
        replanner.update(replace(closing(1.0, 0.5), t=k * tick), None)
    first = round(3.0 * tick / TICK)  # at 100 Hz they are the numbers of the ticks
    assert turns == list(range(first, first + 6))


@pytest.mark.parametrize("back", [0.0, 0.4])
def test_who_is_not_measured_for_forget_has_broken_the_promise_until_it_is(back: float) -> None:
    """For one that was never measured it counts from the first tick, but for that of a clock set back."""
    replanner, broken = SafeReplanner(PARAMS), []
    for k in range(300):
        t, still = k * TICK - (back if k >= 30 else 0.0), closing(3.0, 0.0)
        gone = k * TICK - 0.995 if 100 <= k < 200 else 0.0
        age = np.array([gone, np.inf if k < 250 else 0.0])
        state = resting_state(t, PAIR, still.pos, age=age)
        answer = replanner.update(replace(still, t=t), state)
        broken.append(answer.status == BROKEN)
    first, second = (np.flatnonzero(row).tolist() for row in np.transpose(broken))
    forget = round(PARAMS.forget / TICK)
    assert first == list(range(100 + forget, 200))
    assert second == list(range(forget + (2 if back else 1), 250))


def test_who_meets_somebody_is_asked_for_no_more_than_it_may_accelerate() -> None:
    """A reference of 6 m/s^2 sideways is shortened to 3 where there is somebody to mind, in its direction."""
    hard = np.array([[0.0, 2.0, 0.0], [0.0, 2.0, 0.0]]) * [1.0, 3.0, 1.0] + [[0.0, 0.0, 4.0]] * 2
    near = SafeReplanner(PARAMS).update(closing(1.0, 0.0, hard), None)
    np.testing.assert_allclose(near.acc, 3.0 * hard / np.sqrt(52.0), rtol=1e-12)
    far = closing(50.0, 0.0, hard)
    assert SafeReplanner(PARAMS).update(far, None) is far


@pytest.mark.parametrize("away", [0.0, 0.3])
def test_who_was_pushed_and_is_alone_again_goes_back_by_the_tracking_law(away: float) -> None:
    replanner = SafeReplanner(PARAMS)
    first = replanner.update(closing(1.0, 0.6), None)
    pos = first.pos[:1] + TICK * first.vel[:1] + 0.5 * TICK**2 * first.acc[:1]
    vel = first.vel[:1] + TICK * first.acc[:1]
    reference = setpoint(
        TICK,
        ("cf1",),
        pos + np.array([[0.03, -0.05, 0.07]]) + away,
        vel + np.array([[0.02, 0.04, -0.06]]),
        np.array([[0.3, 0.2, 0.1]]),
    )
    output = replanner.update(reference, None)
    np.testing.assert_allclose(output.pos, pos, atol=1e-15)
    np.testing.assert_allclose(output.vel, vel, atol=1e-15)
    expected = (
        reference.acc + PARAMS.k_d * (reference.vel - output.vel) + PARAMS.k_p * (reference.pos - output.pos)
    )
    size = float(np.linalg.norm(expected))
    assert (size > PARAMS.acc_max) == (away > 0.0)
    np.testing.assert_allclose(output.acc, expected * min(1.0, PARAMS.acc_max / size), rtol=1e-12)
    assert output.status.tolist() == [SetpointStatus.SHIFTED]


def test_who_was_pushed_is_not_put_onto_its_reference_at_the_next_tick() -> None:
    replanner = SafeReplanner(PARAMS)
    first = replanner.update(closing(1.0, 0.6), None)
    pos, vel = first.pos + TICK * first.vel + 0.5 * TICK**2 * first.acc, first.vel + TICK * first.acc
    output = replanner.update(setpoint(TICK, PAIR, pos + SNAP_POS / 4.0, vel), None)
    np.testing.assert_allclose(output.pos, pos, atol=1e-12)


def test_a_pair_that_is_pushed_too_late_brakes_as_it_was_proven_to() -> None:
    """At 1 m/s each, 20/s of approach ask for a push when 3 m/s^2 no longer stop them; then both brake."""
    replanner = SafeReplanner(replace(PARAMS, approach=20.0))
    references = (replace(closing(2.0 - 2.0 * k * TICK, 1.0), t=k * TICK) for k in range(90))
    flown_by = [replanner.update(one, None) for one in references]
    assert all((one.status != BROKEN).all() for one in flown_by)
    braking = [one for one in flown_by if np.allclose(one.acc, [[-3.0, 0.0, 0.0], [3.0, 0.0, 0.0]])]
    assert len(braking) > 5
    for one, after in itertools.pairwise(flown_by):
        np.testing.assert_allclose(after.vel, one.vel + TICK * one.acc, atol=1e-12)


def test_off_it_says_nothing_is_broken_and_moves_nobody() -> None:
    off = SafeReplanner(replace(PARAMS, enabled=False))
    near = closing(0.1, 1.0)
    strayed = SwarmState(
        0.0, PAIR, near.pos + 1.0, near.vel, np.zeros((2, 4)), near.vel, np.zeros(2), near.status
    )
    assert off.update(near, strayed) is near


LATE = 0.5
"""Age of the stranger's messages [s]."""
FAR = 60.0


def late_stranger(t: float, ours: Array, *, company: bool) -> SwarmState:
    """Return the word on our vehicle, at `ours`, and on a stranger head on; in company behind one far away.

    It comes at 0.5 m/s and from 4 s on faster by 1 m/s^2: against that no new motion is proven for long.
    """
    late = max(0.0, t - LATE - 4.0)
    x, speed = 1.5 - 0.5 * (t - LATE) - 0.5 * late**2, 0.5 + late
    names: Names = ("far9", "cf9", "cf1") if company else ("cf9", "cf1")
    n = len(names)
    pos = np.array([[FAR, 0.0, 1.0], [x, 0.05, 1.0], ours])[-n:]
    vel = np.array([[0.0, 0.0, 0.0], [-speed, 0.0, 0.0], [0.0, 0.0, 0.0]])[-n:]
    age = np.array([LATE, LATE, 0.0])[-n:]
    return SwarmState(t, names, pos, vel, np.zeros((n, 4)), vel, age, np.zeros(n, np.uint8))


def own(t: float, *, company: bool) -> SwarmSetpoint:
    """Return our vehicle's reference, at 0.5 m/s along x; in company behind one that hovers far away."""
    names: Names = ("far1", "cf1") if company else ("cf1",)
    pos = np.array([[0.0, FAR, 1.0], [-1.5 + 0.5 * t, 0.0, 1.0]])[-len(names) :]
    vel = np.array([[0.0, 0.0, 0.0], [0.5, 0.0, 0.0]])[-len(names) :]
    return setpoint(t, names, pos, vel)


def flown(*, company: bool) -> list[SwarmSetpoint]:
    """Return what our vehicle is commanded on its way towards the stranger; company comes and goes.

    From 4.7 s on it alternates between new motions and old ones, that are proven against this stranger.
    """
    replanner, answers = SafeReplanner(PARAMS), []
    for k in range(520):
        t, swarm = k * TICK, company and k % 2 == 0
        ours = answers[-1].pos[0] if answers else own(t, company=False).pos[0]
        received = late_stranger(t, ours, company=company and k < 465)  # forgotten 0.1 s later
        answer = replanner.update(own(t, company=swarm), received)
        pos, vel, acc, status = answer.pos[-1:], answer.vel[-1:], answer.acc[-1:], answer.status[-1:]
        answers.append(replace(answer, names=("cf1",), pos=pos, vel=vel, acc=acc, status=status))
    return answers


@pytest.fixture(scope="module")
def alone() -> list[SwarmSetpoint]:
    """Return the flight without company."""
    return flown(company=False)


def test_what_is_proven_against_a_stranger_follows_vehicles_by_name(alone: list[SwarmSetpoint]) -> None:
    """Where company is forgotten, that is announced."""
    both = list(zip(alone, flown(company=True), strict=True))
    for one, other in both:
        np.testing.assert_array_equal(one.pos, other.pos)
    differ = [other.status.tolist() for one, other in both if one.status.tolist() != other.status.tolist()]
    assert differ == [[BROKEN]]


def test_a_setpoint_accelerates_as_it_says_also_where_it_brakes_on_an_old_motion(
    alone: list[SwarmSetpoint],
) -> None:
    """Holds are of two ticks, so an answer's acceleration is that of all its tick, unless it stops in it."""
    assert all(one.status[0] != BROKEN for one in alone)
    for one, after in itertools.pairwise(alone):
        if np.linalg.norm(one.vel) > PARAMS.acc_max * TICK or not one.vel.any():
            np.testing.assert_allclose(after.vel, one.vel + TICK * one.acc, atol=1e-12)
