"""A measured vehicle below one that is not measured, or little above it, leaves its column."""

from dataclasses import replace

import numpy as np
import pytest
from evading_flights import TICK, UPPER, flown, setpoint_of, state_of
from hypothesis import given, settings
from hypothesis import strategies as st

from q2q_control.failsafe.evasion import descent_evasion
from q2q_control.failsafe.evasion.climb_back import InFallback
from q2q_control.failsafe.evasion.descent_evasion import (
    DRIFT,
    DRIFT_FROM_S,
    FARTHEST,
    REACH,
    RISE,
    DescentEvasion,
)
from q2q_control.failsafe.evasion.evasion_shift import PACE
from q2q_control.failsafe.tracking_loss.dead_reckoned_braking import Reckoned
from q2q_model.signals.values import CommandStatus, TrackStatus

LOST = flown(2, 0)
"""The upper one of two vehicles is lost."""


def shifts(pos: np.ndarray, ticks: int, fallback: InFallback, vel: np.ndarray | None = None) -> np.ndarray:
    """Return by how much every setpoint is moved at every tick, (ticks, n, 9); vehicles are where sent."""
    way, made = DescentEvasion(), []
    speed = np.zeros_like(pos) if vel is None else vel
    for k in range(ticks):
        sent = setpoint_of(k * TICK, pos + speed * k * TICK, speed)
        output = way.update(sent, state_of(sent.pos), fallback, {})
        made.append(
            np.concatenate([output.pos - sent.pos, output.vel - sent.vel, output.acc - sent.acc], axis=1)
        )
    return np.array(made)


@pytest.mark.parametrize("how", [CommandStatus.LEVEL, CommandStatus.LAND])
@pytest.mark.parametrize("height", [1.0, UPPER[2], UPPER[2] + 0.99 * RISE])
def test_who_is_in_the_column_leaves_straight_away_as_a_critically_damped_motion_does(
    height: float, how: CommandStatus
) -> None:
    pos = np.array([UPPER, (0.3, 0.4, height)])
    made = shifts(pos, 300, flown(2, 0, how=how))
    t = np.arange(1, 301) * TICK
    way = (REACH - 0.5) * (1.0 - (1.0 + PACE * t) * np.exp(-PACE * t))
    # steps of 10 ms, semi-implicit: w dt / 2 = 1.5 % of the way
    np.testing.assert_allclose(made[:, 1, :2], way[:, None] * [0.6, 0.8], atol=0.015 * 0.1)
    assert not made[:, 0].any()
    assert not made[:, :, 2].any()


@pytest.mark.parametrize("other", [(REACH + 0.01, 0.0, 0.5), (0.0, 0.0, UPPER[2] + 1.01 * RISE)])
def test_who_is_not_in_the_column_is_left_alone(other: tuple[float, float, float]) -> None:
    assert not shifts(np.array([UPPER, other]), 100, flown(2, 0)).any()


def test_who_is_near_the_place_to_which_another_may_have_drifted_evades() -> None:
    pos = np.array([UPPER, (0.8, 0.0, 1.0)])
    state = replace(state_of(pos), age=np.array([DRIFT_FROM_S + 0.6, 0.0]))
    made = [
        DescentEvasion().update(setpoint_of(0.0, pos), one, flown(2, 0), {}).acc[1, 0]
        for one in (state_of(pos), state)
    ]
    assert made == [0.0, pytest.approx(PACE**2 * (REACH + 0.6 * DRIFT - 0.8) + 2.0 * PACE * DRIFT)]


def test_no_direction_is_chosen_for_what_has_no_setpoint(monkeypatch: pytest.MonkeyPatch) -> None:
    """Changing names of a marker beneath a lost vehicle took seconds of a tick."""
    chosen: list[tuple[int, int]] = []

    def choose(_: np.ndarray, pair: tuple[int, int], *__: object) -> np.ndarray:
        chosen.append(pair)
        return np.array([1.0, 0.0])

    monkeypatch.setattr(descent_evasion, "evasion_direction", choose)
    pos = np.array([UPPER, (0.3, 0.4, 1.0), (0.0, 0.3, 1.0)])
    DescentEvasion().update(setpoint_of(0.0, pos[:2]), state_of(pos), flown(3, 0), {})
    assert chosen == [(1, 0)]


@pytest.mark.parametrize("how", [CommandStatus.OK, CommandStatus.HOLD, CommandStatus.CUT])
def test_who_is_seen_or_held_for_a_moment_or_down_is_not_evaded(how: CommandStatus) -> None:
    sent = setpoint_of(0.0, np.array([UPPER, (0.0, 0.0, 1.0)]))
    assert DescentEvasion().update(sent, state_of(sent.pos), flown(2, 0, how=how), {}) is sent


def test_two_lost_ones_move_nobody_and_one_that_is_seen_between_leaves_both() -> None:
    stack = np.array([UPPER, (0.1, 0.0, 1.0), (0.0, 0.1, 0.5)])
    assert not shifts(stack, 100, flown(3, 0, 1, 2)).any()
    made = shifts(stack, 300, flown(3, 0, 2))
    end = stack[1, :2] + made[-1, 1, :2]
    assert np.linalg.norm(end - stack[[0, 2], :2], axis=1).min() > 0.99 * REACH
    assert not made[:, [0, 2]].any()


@settings(max_examples=25)
@given(
    begin=st.tuples(*[st.floats(-0.4, 0.4)] * 2),
    vel=st.tuples(*[st.floats(-0.5, 0.5)] * 2),
)
def test_a_setpoint_that_passes_beneath_goes_round(
    begin: tuple[float, float], vel: tuple[float, float]
) -> None:
    """The lost one stays; after the way there, 3 / w and more, the passing one is REACH away from it."""
    speed = np.array([(0.0, 0.0, 0.0), (*vel, 0.0)])
    way, pos = DescentEvasion(), np.array([UPPER, (*begin, 0.8)])
    place = pos
    for k in range(400):
        sent = setpoint_of(k * TICK, pos + speed * k * TICK, speed)
        output = way.update(sent, state_of(place), flown(2, 0), {})
        place = np.array([UPPER, output.pos[1]])
        if k > 200:
            assert np.linalg.norm(output.pos[1, :2]) > REACH - 0.02


@pytest.mark.parametrize("age", [1.0, 2.5, 4.5])
def test_the_longer_another_is_lost_the_further_it_is_evaded(age: float) -> None:
    evasion, pos = DescentEvasion(), np.array([UPPER, (0.3, 0.0, 1.0)])
    state = replace(state_of(pos), age=np.array([age, 0.0]))
    for k in range(400):
        output = evasion.update(setpoint_of(k * TICK, pos), state, flown(2, 0), {})
    kept = min(REACH + DRIFT * max(age - DRIFT_FROM_S, 0.0), FARTHEST)
    assert output.pos[1, 0] == pytest.approx(kept, abs=1e-3)


def test_a_distance_that_grows_is_kept_without_a_lag() -> None:
    """What is left of the way is d' t exp(-w t), 0.03 m as the growth ends; not fed forward, 0.21 m."""
    evasion, pos, kept = DescentEvasion(), np.array([UPPER, (0.0, 0.0, 1.0)]), []
    grown = np.arange(int((FARTHEST - REACH) / DRIFT / TICK)) * TICK
    for k, age in enumerate(np.append(np.zeros(400), DRIFT_FROM_S + grown)):
        state = replace(state_of(pos), age=np.array([age, 0.0]))
        kept.append(evasion.update(setpoint_of(k * TICK, pos), state, LOST, {}).pos[1, 0])
    left = DRIFT * grown * np.exp(-PACE * grown)
    np.testing.assert_allclose(kept[400:], REACH + DRIFT * grown - left, atol=2 * DRIFT * TICK)  # two ticks


def test_who_is_not_measured_itself_any_more_comes_to_rest() -> None:
    """Lost while it evades, it would drift on; its shift goes on by s' / w, by s'' = -w s'."""
    evasion, pos, made = DescentEvasion(), np.array([UPPER, (0.0, 0.0, 1.0)]), []
    for k in range(300):
        status = np.array([TrackStatus.LOST, TrackStatus.COASTING if k >= 30 else TrackStatus.TRACKED])
        output = evasion.update(setpoint_of(k * TICK, pos), replace(state_of(pos), status=status), LOST, {})
        made.append((output.pos[1, 0], output.vel[1, 0]))
    way, speed = np.array(made).T
    assert speed[29] > 0.3
    np.testing.assert_allclose(speed[30:], speed[29] * (1.0 - PACE * TICK) ** np.arange(1, 271), rtol=1e-9)
    assert way[-1] == pytest.approx(way[29] + speed[29] / PACE, abs=0.01)  # semi-implicit: w dt of the rest


def test_velocity_and_acceleration_are_those_of_the_motion() -> None:
    made = shifts(np.array([UPPER, (0.1, -0.1, 1.0)]), 200, flown(2, 0), np.array([[0.0] * 3, [0.3, 0.1, 0]]))
    pos, vel, acc = (made[:, 1, k : k + 2] for k in (0, 3, 6))
    np.testing.assert_allclose(np.diff(pos, axis=0), vel[1:] * TICK, atol=1e-12)
    np.testing.assert_allclose(np.diff(vel, axis=0), acc[1:] * TICK, atol=1e-12)


def test_the_side_without_others_is_taken() -> None:
    """Straight away from the lost one another vehicle hovers, 45 degrees aside is too near to it: across."""
    pos = np.array([UPPER, (0.05, 0.0, 1.0), (0.6, 0.0, 1.0)])
    made = shifts(pos, 300, flown(3, 0))
    # what is left of the way after 3 s: (1 + w t) exp(-w t) = 0.12 %
    np.testing.assert_allclose(pos[1, :2] + made[-1, 1, :2], [0.05, REACH], atol=2e-3)


def test_where_in_the_room_it_happens_does_not_matter() -> None:
    pos = np.array([UPPER, (0.1, 0.2, 1.0), (0.4, 0.5, 0.9)])
    here, there = (
        shifts(pos + np.array([x, y, 0.0]), 100, flown(3, 0)) for x, y in ((0.0, 0.0), (3.0, -2.0))
    )
    assert here[-1, 1].any()
    np.testing.assert_allclose(there, here, atol=1e-12)


def test_four_fifths_of_the_way_are_flown_from_level_to_landing() -> None:
    """1 - (1 + w t) exp(-w t) after 1 s, by an acceleration of w^2 times the way at first."""
    made = shifts(np.array([UPPER, (0.0, 0.0, 1.0)]), 100, flown(2, 0))
    assert made[-1, 1, 0] == pytest.approx(0.8 * REACH, rel=0.02)
    assert np.abs(made[:, 1, 6]).max() == pytest.approx(5.4)


def test_beneath_two_lost_ones_the_way_leads_from_both() -> None:
    pos = np.array([UPPER, (0.3, 0.0, 1.6), (0.1, -0.1, 1.0)])
    vel = np.array([(0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.1, 0.0, 0.0)])
    way, made = DescentEvasion(), []
    for k in range(300):
        sent = setpoint_of(k * TICK, pos + vel * k * TICK, vel)
        place = pos if not made else np.array([*pos[:2], made[-1]])
        made.append(way.update(sent, state_of(place), flown(3, 0, 1), {}).pos[2])
    away = np.linalg.norm(made[-1][:2] - pos[:2, :2], axis=1)
    assert away.min() > 0.98 * REACH


def test_after_a_gap_between_ticks_a_setpoint_moves_as_in_a_tenth_of_a_second() -> None:
    pos, moved = np.array([UPPER, (0.1, 0.0, 1.0)]), []
    for gap in (0.1, 2.0):
        way = DescentEvasion()
        for t in (0.0, gap):
            output = way.update(setpoint_of(t, pos), state_of(pos), flown(2, 0), {})
        moved.append(output.pos[1, 0] - 0.1)
    assert moved[0] == moved[1] > 0.0


def test_who_was_never_placed_or_has_left_the_state_moves_nobody() -> None:
    pos = np.array([(np.nan, 0.0, 1.5), (0.0, 0.0, 1.0)])
    assert not shifts(pos, 50, flown(2, 0))[:, 1].any()
    way, pos = DescentEvasion(), np.array([UPPER, (0.0, 0.0, 1.0)])
    for k in range(50):
        way.update(setpoint_of(k * TICK, pos), state_of(pos), flown(2, 0), {})
    alone = replace(state_of(pos[1:]), names=("cf2",))
    for k in range(50, 500):
        output = way.update(setpoint_of(k * TICK, pos), alone, flown(2, 0), {})
    np.testing.assert_array_equal(output.pos, pos)


def test_way_is_made_where_the_lost_one_is_reckoned_to_be_not_where_it_was_seen() -> None:
    pos = np.array([(0.0, -0.8, 1.5), (0.0, 0.0, 1.0)])
    way, sent = DescentEvasion(), setpoint_of(0.0, pos)
    np.testing.assert_array_equal(way.update(sent, state_of(pos), flown(2, 0), {}).pos, pos)
    known = {"cf1": Reckoned(np.array([0.0, -0.3]), np.array([0.0, -0.3]))}
    for k in range(1, 300):
        output = way.update(setpoint_of(k * TICK, pos), state_of(pos), flown(2, 0), known)
    np.testing.assert_allclose(output.pos[1], [0.0, REACH - 0.3, 1.0], atol=0.01)


@pytest.mark.parametrize("first", [0, 1])
def test_who_is_sent_beneath_the_lost_one_from_afar_stops_on_its_side(first: int) -> None:
    """Measured again elsewhere, it goes to its setpoint; the lost one stays, 0.5 m above that."""
    order, fallback = [first, 1 - first], flown(2, first)
    sent, pos = np.array([UPPER, (0.0, 0.0, 1.0)])[order], np.array([UPPER, (-0.3, -1.0, 1.0)])[order]
    way = DescentEvasion()
    for k in range(300):
        output = way.update(setpoint_of(k * TICK, sent), state_of(pos), fallback, {})
    assert output.pos[1 - first] @ pos[1 - first] > 0.0
    assert np.hypot(*output.pos[1 - first, :2]) > 0.98 * REACH


def test_where_the_lost_one_is_sent_nobody_is_in_its_way() -> None:
    sent, pos = np.array([(2.0, 0.0, 1.5), (2.0, 0.0, 1.0)]), np.array([UPPER, (2.0, 0.0, 1.0)])
    way = DescentEvasion()
    for k in range(100):
        output = way.update(setpoint_of(k * TICK, sent), state_of(pos), flown(2, 0), {})
    np.testing.assert_array_equal(output.pos, sent)


def test_without_setpoints_nobody_is_moved() -> None:
    pos, none = np.array([UPPER, (0.0, 0.0, 1.0)]), setpoint_of(0.0, np.zeros((0, 3)))
    assert not DescentEvasion().update(none, state_of(pos), flown(2, 0), {}).names


def test_way_is_made_across_the_path_of_who_drifts_over_and_not_ahead_of_it() -> None:
    pos = np.array([(0.0, -0.5, 1.5), (0.0, 0.0, 1.0)])
    way = DescentEvasion()
    for k in range(300):
        drifted = np.array([0.0, min(0.01 * k, 1.0) - 0.5])  # 1 m/s, at rest 0.5 m beyond
        known = {"cf1": Reckoned(drifted, np.array([0.0, 0.5]))}
        output = way.update(setpoint_of(k * TICK, pos), state_of(pos), flown(2, 0), known)
    np.testing.assert_allclose(np.abs(output.pos[1]), [REACH, 0.0, 1.0], atol=0.01)
