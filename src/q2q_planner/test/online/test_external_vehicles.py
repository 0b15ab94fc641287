"""The safe law evades vehicles that are measured and not led, and says when it cannot promise to."""

from dataclasses import replace

import numpy as np
import pytest
from safe_flights import BROKEN, PARAMS, TICK, ZONE, hover, seen, swap

from q2q_model.estimation.mocap_filter import MocapFilter
from q2q_model.estimation.mocap_filter_params import MocapFilterParams
from q2q_model.signals.values import Array, MocapFrame, SwarmSetpoint
from q2q_model.trajectory.polynomials import setpoint_at
from q2q_planner.online.safe.safe_replanner import SafeReplanner


def rammed(speed: float, *, chases: bool) -> tuple[list[bool], list[bool]]:
    """Return in which ticks the promise is broken, and a stranger inside our vehicle's zone.

    The stranger comes from 3 m away and never brakes, which breaks condition 3; our vehicle hovers.
    """
    plan, replanner = hover(9.0), SafeReplanner(PARAMS)
    announced, inside = [], []
    there, ours = np.array([-3.0, 0.05, 1.2]), np.array([0.0, 0.0, 1.0])
    for k in range(600):
        reference = setpoint_at(plan, k * TICK)
        ahead = ours + np.array([0.0, 0.0, 0.2]) - there if chases else np.array([1.0, 0.0, 0.0])
        vel = speed * ahead / max(float(np.linalg.norm(ahead)), 1e-9)
        state = replace(seen(reference), names=("cf9",), pos=there[None], vel=vel[None])
        answer = replanner.update(reference, state)
        announced.append(bool(answer.status[0] == BROKEN))
        inside.append(bool(ZONE.signed_distance(answer.pos[0] - there) < 0.0))
        there, ours = there + vel * TICK, answer.pos[0]
    return announced, inside


def test_a_stranger_that_passes_without_braking_is_announced_and_kept_out() -> None:
    announced, inside = rammed(1.0, chases=False)
    assert not announced[0]
    assert any(announced)
    assert not any(inside)


def test_a_stranger_that_chases_faster_than_any_evasion_is_announced_before_it_is_inside() -> None:
    announced, inside = rammed(5.0, chases=True)
    assert any(inside)
    assert announced.index(True) < inside.index(True)


@pytest.mark.parametrize(("eps", "broken"), [(PARAMS.eps, False), (0.3, True)])
def test_a_larger_zone_is_not_promised_by_proofs_of_a_smaller_one(eps: float, broken: bool) -> None:
    """A stranger at rest 0.74 m away may speed up and brake outside a zone of 0.2 m, not of 0.3 m."""
    plan, replanner = hover(9.0), SafeReplanner(PARAMS)

    def is_broken(k: int) -> bool:
        reference = setpoint_at(plan, k * TICK)
        stranger = replace(seen(reference), names=("cf9",), pos=np.array([[0.74, 0.0, 1.2]]))
        return bool(replanner.update(reference, stranger).status[0] == BROKEN)

    assert not any(is_broken(k) for k in range(10))
    replanner.configure(replace(PARAMS, eps=eps))
    assert is_broken(10) is broken


@pytest.mark.parametrize("jump_s", [0.4, 100.0])
def test_a_stranger_is_evaded_as_well_after_the_clock_was_set_back(jump_s: float) -> None:
    """It comes at 0.5 m/s from 2.5 m away and stops 0.3 m away; the clock jumps after 2 s."""
    plan = hover(9.0)

    def flown(jump_s: float) -> list[SwarmSetpoint]:
        replanner, answers = SafeReplanner(PARAMS), []
        for k in range(600):
            braked = np.clip(k * TICK - 4.15, 0.0, 0.5)  # at 1 m/s^2
            x = -2.5 + 0.5 * min(k * TICK, 4.65) - 0.5 * braked**2
            there, vel = np.array([[x, 0.05, 1.2]]), np.array([[0.5 - braked, 0.0, 0.0]])
            reference = replace(setpoint_at(plan, 0.0), t=200.0 + k * TICK - (jump_s if k >= 200 else 0.0))
            ours = answers[-1] if answers else reference
            pos, vel = np.concatenate([ours.pos, there]), np.concatenate([ours.vel, vel])
            both = replace(reference, names=("cf1", "cf9"), pos=pos, vel=vel)
            answers.append(replanner.update(reference, seen(both)))
        return answers

    steady, jumped = flown(0.0), flown(jump_s)
    shifted = max(np.linalg.norm(tick.pos[0] - [0.0, 0.0, 1.0]) for tick in steady)
    assert shifted > 0.05
    for one, other in zip(steady[202:], jumped[202:], strict=True):
        np.testing.assert_allclose(other.pos, one.pos, atol=1e-9)
        assert other.status.tolist() == one.status.tolist()


def test_a_stranger_unheard_of_grows_its_zone_until_it_is_forgotten() -> None:
    plan, replanner = hover(30.0), SafeReplanner(PARAMS)
    near = replace(
        seen(setpoint_at(plan, 0.0)), names=("cf9",), pos=np.array([[0.6, 0.0, 1.0]]), vel=np.zeros((1, 3))
    )
    shifts = [replanner.update(setpoint_at(plan, k * TICK), near).pos[0, 0] for k in range(1200)]
    assert shifts[0] == 0.0
    assert shifts[60] < -0.05  # 0.6 s of silence: it may be 0.54 m nearer
    assert shifts[150] < shifts[60]
    assert shifts[1199] == 0.0  # forgotten after 2 s, and back on the reference


@pytest.mark.parametrize("back", [0.4, 6.0])
def test_a_stranger_unheard_of_is_forgotten_no_later_for_a_clock_set_back(back: float) -> None:
    """But for the tick in which the clock is set back, whose length is not known; here 0.5 s later."""
    replanner, said = SafeReplanner(PARAMS), []
    for k in range(300):
        reference = replace(setpoint_at(hover(9.0), 0.0), t=10.0 + k * TICK - (back if k >= 50 else 0.0))
        far = replace(seen(reference), pos=np.array([[50.0, 0.0, 1.0]]), names=("cf9",))
        said.append(replanner.update(reference, seen(reference) if k else far).status[0] == BROKEN)
    assert np.flatnonzero(said).tolist() == [round(PARAMS.forget / TICK) + 2]


@pytest.mark.parametrize("jerk_max", [0.0, 20.0])
def test_all_say_in_which_tick_a_stranger_is_forgotten(jerk_max: float) -> None:
    """Also where it was too far away to matter; vehicles of the swarm are not missed in this way."""
    replanner = SafeReplanner(replace(PARAMS, jerk_max=jerk_max))
    apart = setpoint_at(swap(), 0.0)
    stranger = replace(seen(apart), names=("cf1", "cf9"), pos=apart.pos + np.array([0.0, 50.0, 0.0]))
    said = []
    for k in range(400):
        state = stranger if k == 0 else replace(seen(apart), t=k * TICK)
        said.append((replanner.update(replace(apart, t=k * TICK), state).status == BROKEN).tolist())
    assert said.index([True, True], 1) == round(PARAMS.forget / TICK) + 1
    assert said.count([True, True]) == 1
    assert said[1:].count([False, False]) == 398


def test_a_stranger_that_was_never_upright_is_evaded_as_one_that_is() -> None:
    """It comes at 0.5 m/s from 1.2 m away; its quaternions are sent as w, x, y, z or as they are."""
    plan, upright = hover(9.0), np.array([[0.0, 0.0, 0.0, 1.0]])

    def flown(quat: Array) -> list[float]:
        replanner, block = SafeReplanner(PARAMS), MocapFilter(MocapFilterParams(), ("cf9",))
        answers: list[float] = []
        for k in range(150):
            reference, place = setpoint_at(plan, k * TICK), np.array([[-1.2 + 0.5 * k * TICK, 0.05, 1.2]])
            stranger = block.update(MocapFrame(k * TICK, ("cf9",), place, quat))
            answers.append(float(replanner.update(reference, stranger).pos[0, 0]))
        return answers

    assert flown(upright[:, [3, 0, 1, 2]]) == flown(upright)
    assert max(flown(upright)) > 0.05
