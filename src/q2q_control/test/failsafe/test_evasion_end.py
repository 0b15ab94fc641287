"""Who evades one that was lost does so until that is back, is led across its path, and comes back."""

from dataclasses import replace

import numpy as np
import pytest
from evading_flights import TICK, UPPER, flown, setpoint_of, state_of

from q2q_control.failsafe.evasion.climb_back import BACK
from q2q_control.failsafe.evasion.descent_evasion import REACH, DescentEvasion
from q2q_control.failsafe.evasion.evasion_shift import PACE
from q2q_model.signals.values import CommandStatus


@pytest.mark.parametrize(
    ("height", "climb", "evaded"), [(1.31, 0.5, False), (1.29, 0.5, True), (1.31, -0.1, True)]
)
def test_one_that_is_measured_again_and_climbs_well_above_is_evaded_no_more(
    height: float, climb: float, evaded: bool
) -> None:
    evasion, plan = DescentEvasion(), np.array([(0.0, 0.0, 2.0), (0.1, 0.0, 1.0)])
    for k in range(200):
        evasion.update(setpoint_of(k * TICK, plan), state_of(plan), flown(2, 0), {})
    assert BACK == 0.3
    found = replace(
        state_of(np.array([(0.0, 0.0, height), (0.6, 0.0, 1.0)])),
        vel=np.array([(0.0, 0.0, climb), (0.0, 0.0, 0.0)]),
    )
    for k in range(200, 400):
        output = evasion.update(setpoint_of(k * TICK, plan), found, flown(2), {})
    assert (output.pos[1, 0] > 0.55) == evaded


@pytest.mark.parametrize(("height", "across"), [(0.1, True), (0.5, False)])
def test_one_that_is_driven_ahead_turns_across_unless_the_other_may_climb_to_its_height_meanwhile(
    height: float, across: bool
) -> None:
    """cf1, found at a height, moves along x at 0.5 m/s under its setpoint; cf2 hovers at 1 m ahead of it."""
    evasion, aside = DescentEvasion(), 0.0
    for k in range(400):
        x = 0.5 * max(k - 100, 0) * TICK
        low = 2.0 if k < 100 else height
        state = state_of(np.array([(x, 0.0, low), (0.3 if k < 100 else x + 0.5, 0.0, 1.0)]))
        plan = np.array([(x, 0.0, 2.0), (0.3, 0.0, 1.0)])
        fallback = flown(2, 0) if k < 100 else flown(2)
        output = evasion.update(setpoint_of(k * TICK, plan), state, fallback, {})
        aside = max(aside, abs(output.pos[1, 1]))
    assert (aside > 0.3) == across


def test_one_that_is_sent_far_past_the_other_does_not_turn_at_every_tick() -> None:
    """cf1 is found at rest on the floor; both ahead of it and across, the setpoint of cf2 is far off."""
    evasion, sent = DescentEvasion(), np.array([UPPER, (-0.69, 0.88, 1.5)])
    accelerations = []
    for k in range(200):
        low = UPPER[2] if k < 100 else 0.1
        state = state_of(np.array([(*UPPER[:2], low), (0.05, -0.25, 1.5)]))
        output = evasion.update(setpoint_of(k * TICK, sent), state, flown(2, 0) if k < 100 else flown(2), {})
        accelerations.append(output.acc[1, :2])
    assert np.abs(np.diff(accelerations[101:], axis=0)).max() < 1.0


@pytest.mark.parametrize(("end", "aside"), [(0.5, 0.5), (0.7, 0.0)])
def test_who_has_moved_past_a_lost_one_goes_back_to_its_setpoint(end: float, aside: float) -> None:
    """The setpoint of cf2 is 0.1 m beside the lost vehicle for 2 s, then moves on to a distance along x."""
    evasion = DescentEvasion()
    for k in range(700):
        x = min(max(0.5 * (k - 200) * TICK, 0.0), end)
        sent = setpoint_of(k * TICK, np.array([UPPER, (x, 0.1, 1.0)]))
        output = evasion.update(sent, state_of(sent.pos), flown(2, 0), {})
        assert k < 200 or np.hypot(*output.pos[1, :2]) > REACH - 0.02
    np.testing.assert_allclose(output.pos[1, :2], [end, 0.1 + aside], atol=1e-3)


@pytest.mark.parametrize(("x", "kept"), [(-0.3, True), (0.7, False)])
def test_one_whose_setpoint_is_beyond_a_lost_one_stays_on_its_side(x: float, kept: bool) -> None:
    """It is 0.3 m before the lost vehicle, or already past it, and is sent 0.8 m past it."""
    evasion, sent = DescentEvasion(), np.array([UPPER, (0.8, 0.0, 1.0)])
    for k in range(400):
        state = state_of(np.array([UPPER, (-0.3 if k < 100 else x, 0.0, 1.0)]))
        output = evasion.update(setpoint_of(k * TICK, sent), state, flown(2, 0), {})
    np.testing.assert_allclose(output.pos[1, :2], [-REACH if kept else 0.8, 0.0], atol=1e-2)


def test_seen_again_everybody_flies_where_it_is_sent_to_the_last_digit() -> None:
    way, pos = DescentEvasion(), np.array([UPPER, (0.0, 0.0, 1.0)])
    for k in range(200):
        way.update(setpoint_of(k * TICK, pos), state_of(pos), flown(2, 0), {})
    assert way.active
    moved = []
    for k in range(200, 700):
        sent = setpoint_of(k * TICK, pos)
        output = way.update(sent, state_of(pos), flown(2), {})
        moved.append(float(np.linalg.norm(output.pos[1] - pos[1])))
    assert not way.active
    assert output is sent
    assert np.all(np.diff(moved) <= 1e-12)  # no overshoot
    assert np.diff(moved).min() > -0.4 * PACE * REACH * TICK  # nor a jump: w s / e at most
    way.update(setpoint_of(7.0, pos), state_of(pos), flown(2, 0), {})
    way.reset()
    assert not way.active


@pytest.mark.parametrize("cut", [False, True])
def test_who_climbs_back_from_the_floor_is_evaded_until_it_is_near_its_setpoint(cut: bool) -> None:
    sent = np.array([UPPER, (0.0, 0.0, 1.0)])
    way, pos = DescentEvasion(), sent.copy()
    for k in range(300):
        pos[0, 2] = max(UPPER[2] - 0.01 * k, 0.0)
        output = way.update(setpoint_of(k * TICK, sent), state_of(pos), flown(2, 0), {})
    seen = flown(2, 0, how=CommandStatus.CUT) if cut else flown(2)
    shift = [float(np.hypot(*output.pos[1, :2]))]
    for k in range(300, 600):
        pos[0, 2] = 0.01 * (k - 300) * UPPER[2] / 2.0
        output = way.update(setpoint_of(k * TICK, sent), state_of(pos), seen, {})
        shift.append(float(np.hypot(*output.pos[1, :2])))
    back = round((UPPER[2] - BACK) / UPPER[2] * 200)
    assert shift[0] == pytest.approx(REACH, abs=0.01)
    assert (shift[back - 1] < 0.1 * REACH) == cut
    assert shift[-1] < 0.25 * REACH


def test_who_climbs_back_does_so_where_it_is_and_is_led_aside_only_at_its_height() -> None:
    sent = np.array([(0.5, 0.0, 1.5), (0.0, 0.0, 1.0)])
    way, pos = DescentEvasion(), np.array([(0.1, 0.0, 1.5), (0.0, 0.0, 1.0)])
    for k in range(200):
        way.update(setpoint_of(k * TICK, sent), state_of(pos), flown(2, 0), {})
    for height in (0.2, 0.7, 1.5 - 1.01 * BACK):
        pos[0] = [0.1 + 0.01 * height, 0.0, height]  # it drifts a little
        output = way.update(setpoint_of(2.0 + height, sent), state_of(pos), flown(2), {})
        np.testing.assert_allclose(output.pos[0], [0.102, 0.0, 1.5], atol=1e-12)
    pos[0, 2] = 1.5 - 0.99 * BACK
    output = way.update(setpoint_of(4.0, sent), state_of(pos), flown(2), {})
    np.testing.assert_array_equal(output.pos[0], sent[0])


def test_who_is_back_at_its_height_drives_nobody_ahead_on_its_way() -> None:
    """The upper one is measured again 1 m behind its setpoint, and follows it over the one that evaded."""
    sent = np.array([(1.0, 0.0, 1.5), (0.0, 0.0, 1.0)])
    way, pos = DescentEvasion(), np.array([(0.0, 0.0, 1.5), (0.0, 0.0, 1.0)])
    for k in range(200):
        way.update(setpoint_of(k * TICK, sent), state_of(pos), flown(2, 0), {})
    assert way.active
    for k in range(200, 600):
        pos[0, 0] = sent[0, 0] = 1.0 + 0.005 * (k - 200)
        pos[0, 0] -= 0.9
        output = way.update(setpoint_of(k * TICK, sent), state_of(pos), flown(2), {})
        assert np.hypot(*output.pos[1, :2]) < REACH + 0.01
    np.testing.assert_allclose(output.pos, sent, atol=1e-3)


def test_who_is_found_again_is_evaded_while_a_replanned_setpoint_climbs_with_it() -> None:
    """Its setpoint begins where it is found, sinking, turns at rest for a moment, and stops at its height."""
    sent, way = np.array([UPPER, (0.0, 0.0, 1.0)]), DescentEvasion()
    pos = sent.copy()
    for k in range(300):
        pos[0, 2] = 1.5 - 0.003 * k
        way.update(setpoint_of(k * TICK, sent), state_of(pos), flown(2, 0), {})
    speed, shift, height = -0.9, [], []
    for k in range(300, 900):
        left = UPPER[2] - pos[0, 2]
        acc = 3.0 if k < 360 else -1.5 if speed > 0.0 and left < speed**2 / 3.0 else 0.0
        speed = max(speed + acc * TICK, -0.9 if k < 360 else 0.0)
        pos[0, 2] += speed * TICK
        vel, change = np.array([[0.0, 0.0, speed], [0.0] * 3]), np.array([[0.0, 0.0, acc], [0.0] * 3])
        replanned = replace(setpoint_of(k * TICK, pos, vel), acc=change)
        replanned.pos[1] = sent[1]
        output = way.update(replanned, state_of(pos), flown(2), {})
        np.testing.assert_array_equal(output.pos[0], pos[0])  # it flies its new motion
        shift.append(float(np.hypot(*output.pos[1, :2])))
        height.append(pos[0, 2])
    low = np.array(height) < UPPER[2] - BACK
    assert low.sum() > 100
    assert np.array(shift)[low].min() > 0.95 * REACH
    assert shift[-1] < 0.01


def test_who_is_found_again_aside_and_led_back_is_not_shifted_twice() -> None:
    """cf2 evades a lost one, is not measured itself for a moment, and its setpoint begins where it is."""
    evasion, sent = DescentEvasion(), np.array([UPPER, (0.0, 0.0, 1.0)])
    for k in range(200):
        evasion.update(setpoint_of(k * TICK, sent), state_of(sent), flown(2, 0), {})
    aside = np.array([UPPER, (REACH, 0.0, 1.0)])
    evasion.update(setpoint_of(2.0, sent), state_of(aside), flown(2, 0, 1), {})
    for k in range(201, 400):
        output = evasion.update(setpoint_of(k * TICK, sent), state_of(aside), flown(2, 0), {})
        np.testing.assert_allclose(output.pos[1], aside[1], atol=0.1)


@pytest.mark.parametrize(("to", "kept"), [(REACH, 0.0), (-REACH, REACH)])
def test_a_setpoint_that_jumps_to_its_vehicle_ends_the_shift_and_no_other_jump_does(
    to: float, kept: float
) -> None:
    """A replanner restarts the motion of a vehicle that is far from it; the lost one is at the origin."""
    evasion, sent = DescentEvasion(), np.array([UPPER, (0.0, 0.0, 1.0)])
    for k in range(300):
        evasion.update(setpoint_of(k * TICK, sent), state_of(sent), flown(2, 0), {})
    state = state_of(np.array([UPPER, (REACH, 0.0, 1.0)]))
    sent[1, 0] = to
    output = evasion.update(setpoint_of(3.0, sent), state, flown(2, 0), {})
    assert output.pos[1, 0] - to == pytest.approx(kept, abs=0.01)


def test_who_is_led_back_from_beyond_the_lost_one_evades_on_that_side() -> None:
    """cf2 evades along -x, has passed the lost one nevertheless, is lost itself, and found beyond it."""
    evasion, sent = DescentEvasion(), np.array([UPPER, (-0.1, 0.0, 1.0)])
    for k in range(30):
        evasion.update(setpoint_of(k * TICK, sent), state_of(sent), flown(2, 0), {})
    sent[1, 0], beyond = 1.2, np.array([UPPER, (0.4, 0.0, 1.0)])
    evasion.update(setpoint_of(0.3, sent), state_of(beyond), flown(2, 0, 1), {})
    for k in range(31, 200):
        output = evasion.update(setpoint_of(k * TICK, sent), state_of(beyond), flown(2, 0), {})
        assert output.pos[1, 0] > beyond[1, 0] - 0.01


@pytest.mark.parametrize("named", [0, 1])
def test_an_evasion_goes_on_while_the_setpoints_lack_its_vehicle(named: int) -> None:
    """The controller ended by an IndexError where there was no setpoint."""
    evasion, sent = DescentEvasion(), np.array([UPPER, (-0.1, 0.0, 1.0)])
    state, outputs = state_of(sent), []
    for k in range(200):
        count = named if 100 <= k < 110 else 2
        outputs.append(evasion.update(setpoint_of(k * TICK, sent[:count]), state, flown(2, 0), {}))
    assert [len(one.names) for one in outputs[98:112]] == [2, 2, *[named] * 10, 2, 2]
    assert outputs[-1].pos[1, 0] < outputs[99].pos[1, 0] < -0.4
