"""The mocap filter on samples under the names of other vehicles."""

import numpy as np
import pytest
from mocap_frames import (
    COAST_S,
    COASTING,
    IDEAL_SENSING,
    LOST,
    PAIR,
    TRACKED,
    flown_until,
    frame_at,
    same,
    time_of,
    truth_at,
)

from q2q_model.estimation.mocap_filter import MocapFilter
from q2q_model.estimation.mocap_filter_params import MocapFilterParams
from q2q_model.estimation.stray_names import MOST_LOST
from q2q_model.geometry.rotations import identity_quat
from q2q_model.signals.values import Array, MocapFrame, Names, SwarmState


@pytest.mark.parametrize("length", [1, 20, 45])
def test_swapped_markers_are_given_back(length: int):
    block = flown_until(50)
    for tick in range(50, 50 + length):
        state = block.update(frame_at(tick, truth_at(tick)[0][::-1]))
        assert np.array_equal(state.pos, truth_at(tick)[0])
        assert list(state.status) == [TRACKED, TRACKED]
    assert block.report.swapped == 2 * length
    assert np.array_equal(block.update(frame_at(50 + length)).pos, truth_at(50 + length)[0])


def test_a_marker_under_the_name_of_another_is_taken_where_it_fits():
    block = flown_until(50)
    pos = truth_at(50)[0]
    lone = MocapFrame(time_of(50), ("cf1",), pos[1:], identity_quat((1,)))  # cf2's place, cf1's name
    state = block.update(lone)
    assert list(state.status) == [COASTING, TRACKED]
    assert np.array_equal(state.pos[1], pos[1])


def test_a_swap_at_the_very_start_heals():
    block = MocapFilter(IDEAL_SENSING, PAIR)
    for tick in range(20):
        block.update(frame_at(tick, truth_at(tick)[0][::-1]))
    states = [block.update(frame_at(tick)) for tick in range(20, 80)]
    # MOST_BORROWED samples and 60 ms to be convinced
    assert all(np.array_equal(s.pos, truth_at(round(s.t * 100))[0]) for s in states[42:])


@pytest.mark.parametrize("first", [2, 4, 20])
def test_names_exchanged_for_less_than_a_vehicle_may_coast_move_no_track_however_early(first: int):
    right, states = _hovering_with_names_exchanged(range(first, first + 34))
    assert all(right)
    assert all((state.status == TRACKED).all() for state in states[1:])


def _hovering_with_names_exchanged(
    exchanged: range, outlier: int | None = None
) -> tuple[list[bool], list[SwarmState]]:
    """Return for 60 ticks whether both hovering vehicles are accepted where they are, and the states.

    In the tick `outlier`, the first of the exchanged samples is 1 m off.
    """
    block, noise = MocapFilter(MocapFilterParams(), PAIR), np.random.default_rng(0)
    place = truth_at(0)[0]
    states = []
    for tick in range(60):
        seen = place + noise.normal(0.0, 3e-4, (2, 3))
        seen = seen[::-1].copy() if tick in exchanged else seen
        seen[0, 0] += float(tick == outlier)
        states.append(block.update(frame_at(tick, seen)))
    return [bool(np.abs(state.pos - place).max() < 5e-3) for state in states], states


@pytest.mark.parametrize("until", [2, 17, 35])
def test_names_exchanged_from_the_second_frame_on_move_no_track(until: int):
    right, states = _hovering_with_names_exchanged(range(1, until))
    assert all(right)
    assert all((state.status == COASTING).all() for state in states[:until])
    assert all((state.status == TRACKED).all() for state in states[until:])


@pytest.mark.parametrize("outlier", [2, 4, 15])
def test_an_outlier_among_names_exchanged_from_the_second_frame_on_moves_no_track(outlier: int):
    right, states = _hovering_with_names_exchanged(range(1, 20), outlier)
    assert all(right)
    assert all((state.status == TRACKED).all() for state in states[20:])


def test_names_exchanged_in_the_first_frame_alone_are_put_right_once_the_others_have_lasted():
    right, states = _hovering_with_names_exchanged(range(1))
    assert right == [False] * 36 + [True] * 24  # coast_s after the second frame
    assert not any((state.status == TRACKED).any() for state in states[:36])


def _alone(tick: int, pos: Array) -> MocapFrame:
    return MocapFrame(time_of(tick), ("cf1",), pos[None], identity_quat((1,)))


def _with_the_other_lost() -> MocapFilter:
    """Return a filter at tick 99 that has not seen cf2 since tick 49."""
    block = flown_until(50)
    for tick in range(50, 100):
        block.update(_alone(tick, truth_at(tick)[0][0]))
    return block


def test_a_missing_vehicle_under_anothers_name_is_not_accepted_while_that_one_may_coast():
    block = _with_the_other_lost()
    for tick in range(100, 110):  # swaps of rooms last up to 0.1 s
        state = block.update(_alone(tick, truth_at(tick)[0][1]))
        assert list(state.status) == [COASTING, LOST]
        assert np.abs(state.pos[0] - truth_at(tick)[0][0]).max() < 5e-3  # coasting for 0.1 s at 0.5 m/s^2
    state = block.update(_alone(110, truth_at(110)[0][0]))
    assert state.status[0] == TRACKED
    assert np.array_equal(state.pos[0], truth_at(110)[0][0])


def test_a_vehicle_that_truly_is_where_a_missing_one_was_is_found_once_it_has_coasted():
    block = _with_the_other_lost()
    found = 100 + round(COAST_S * 100)
    for tick in range(100, found + 1):
        state = block.update(_alone(tick, truth_at(tick)[0][1]))
        assert (state.status[0] == TRACKED) == (tick == found)
    assert np.array_equal(state.pos[0], truth_at(found)[0][1])


def test_names_put_right_again_are_accepted_as_soon_as_any_jump() -> None:
    """After a gap both are lost, and their names exchanged for 0.2 s."""
    block = flown_until(50)
    for tick in range(120, 140):
        assert list(block.update(frame_at(tick, truth_at(tick)[0][::-1].copy())).status) == [LOST, LOST]
    for tick in range(140, 147):
        state = block.update(frame_at(tick))
        assert list(state.status) == [TRACKED if tick == 146 else LOST] * 2


def _flown_past(until: int, missing_from: int) -> MocapFilter:
    """Return a filter of a hovering cf1, missing from a tick on, and of cf2, which flies past it above."""
    block = MocapFilter(IDEAL_SENSING, PAIR)
    for tick in range(until):
        here = slice(None) if tick < missing_from else slice(1, None)
        pos = np.stack([HOVER, _passing(tick)])
        block.update(MocapFrame(time_of(tick), PAIR[here], pos[here], identity_quat((2,))[here]))
    return block


HOVER = np.array([0.0, 0.0, 1.0])


def _passing(tick: int) -> Array:
    """Return where cf2 is at a tick [m], (3,)."""
    return np.array([0.5, -0.25, 1.5]) + time_of(tick) * np.array([-0.3, 0.5, 0.0])


@pytest.mark.parametrize(("moves_as", "found"), [("cf1", 7), ("cf2", COAST_S * 100 + 1)])
def test_a_marker_that_moves_as_another_vehicle_did_has_to_last(moves_as: str, found: float) -> None:
    """cf1 is missing for 0.06 s; then a marker of its name appears between the two, and none of cf2."""
    block, between = _flown_past(56, 50), _passing(56) - [0.49, 0.0, 0.0]
    for tick in range(56, 100):
        moved = _passing(tick) - _passing(56) if moves_as == "cf2" else 1e-4 * _passing(tick)
        state = block.update(_alone(tick, between + moved))
        assert (state.status[0] == TRACKED) == (tick - 56 >= found - 1)


def test_a_marker_that_goes_on_under_the_name_of_a_lost_vehicle_has_to_last() -> None:
    """cf1 is lost; the marker of cf2 moves by 0.25 m, and 0.2 s later has the name of cf1 for 0.2 s."""
    block, displaced = _flown_past(250, 50), np.array([0.25, 0.0, 0.0])
    for tick in range(250, 290):
        name = "cf2" if tick < 270 else "cf1"
        frame = MocapFrame(time_of(tick), (name,), (_passing(tick) + displaced)[None], identity_quat((1,)))
        assert block.update(frame).status[0] == LOST


def test_labels_exchanged_while_a_lost_vehicle_comes_back_with_a_displaced_marker_are_not_accepted() -> None:
    """cf2 is lost; it appears 0.5 m aside, and 0.04 s later both labels are exchanged for 0.1 s."""
    block, displaced = MocapFilter(IDEAL_SENSING, PAIR), np.array([0.5, 0.0, 0.0])
    for tick in range(129):
        pos = np.stack([HOVER + 1e-4 * tick, _passing(tick)])[:: -1 if tick >= 119 else 1].copy()
        pos[1] += displaced * (tick >= 115)
        here = slice(0, 1) if 50 <= tick < 115 else slice(None)
        state = block.update(MocapFrame(time_of(tick), PAIR[here], pos[here], identity_quat((2,))[here]))
        if tick >= 115:
            assert list(state.status) == [TRACKED if tick < 119 else COASTING, LOST]
            np.testing.assert_allclose(state.pos[0], HOVER + 1e-4 * tick, atol=1e-6)


def test_rows_are_matched_by_name_whatever_their_order_and_company():
    block, twin = flown_until(50), flown_until(50)
    pos = truth_at(50)[0]
    crowd = MocapFrame(
        time_of(50),
        ("ghost", "cf2", "cf1", "cf2"),
        np.stack([pos[0], pos[1], pos[0], pos[1] + 3.0]),
        identity_quat((4,)),
    )
    assert same(block.update(crowd), twin.update(frame_at(50)))
    assert block.report.unknown_names == 1
    assert block.report.repeated_names == 1


def test_without_names_vehicles_are_adopted_as_they_appear():
    block, named = MocapFilter(IDEAL_SENSING, ()), MocapFilter(IDEAL_SENSING, ("cf2", "cf1"))
    empty = MocapFrame(time_of(0), (), np.zeros((0, 3)), np.zeros((0, 4)))
    assert block.update(empty).names == ()
    for tick in range(1, 30):
        rows = [1] if tick < 10 else [0, 1]
        frame = MocapFrame(
            time_of(tick), tuple(PAIR[r] for r in rows), truth_at(tick)[0][rows], identity_quat((len(rows),))
        )
        state, expected = block.update(frame), named.update(frame)
        assert state.names == ("cf2", "cf1")[: len(rows)]
        assert np.allclose(state.pos, expected.pos[: len(rows)], atol=0)
        assert np.allclose(state.vel, expected.vel[: len(rows)], atol=1e-12)  # the same sums in another order


def _beside_a_marker(tick: int) -> MocapFrame:
    """Return a frame of both vehicles and of a marker that has another name in every frame."""
    pos = np.concatenate([truth_at(tick)[0], [[2.0, 0.0, 1.0]]])
    return MocapFrame(time_of(tick), (*PAIR, f"m{tick}"), pos, identity_quat((3,)))


def test_names_that_change_for_ever_do_not_grow_the_state_for_ever():
    block, alone = MocapFilter(IDEAL_SENSING, ()), MocapFilter(IDEAL_SENSING, PAIR)
    for tick in range(300):
        state, expected = block.update(_beside_a_marker(tick)), alone.update(frame_at(tick))
        assert block.refuses_names == (state.names[-1] != f"m{tick}")
        np.testing.assert_allclose(state.pos[:2], expected.pos, atol=1e-12)
        assert (state.status[:2] == expected.status).all()
    assert state.names == (*PAIR, *(f"m{tick}" for tick in range(MOST_LOST)))
    assert block.refuses_names


def _crowd(tick: int, names: Names, lost: bool = False) -> MocapFrame:
    """Return a frame of both vehicles and of others at rest, or without a position."""
    others = np.arange(len(names))[:, None] * [0.2, 0.0, 0.0] + [0.0, 5.0, np.nan if lost else 1.0]
    pos = np.concatenate([truth_at(tick)[0], others])
    return MocapFrame(time_of(tick), (*PAIR, *names), pos, identity_quat((len(pos),)))


def test_names_that_one_frame_had_are_forgotten_when_they_are_lost_but_for_a_few():
    block, alone = MocapFilter(IDEAL_SENSING, ()), MocapFilter(IDEAL_SENSING, PAIR)
    strays = tuple(f"x{k}" for k in range(200))
    for tick in range(100):
        frame = _crowd(tick, strays) if tick == 20 else frame_at(tick)
        state, expected = block.update(frame), alone.update(frame_at(tick))
        np.testing.assert_allclose(state.pos[:2], expected.pos, atol=1e-12)
        np.testing.assert_allclose(state.vel[:2], expected.vel, atol=1e-12)
        assert (state.status[:2] == expected.status).all()
        kept = 0 if tick < 20 else MOST_LOST if state.t - time_of(20) > COAST_S + 0.015 else len(strays)
        assert state.names == (*PAIR, *strays[:kept])
    assert block.warnings.missing == strays[:MOST_LOST]
    states = [block.update(_crowd(tick, strays)) for tick in range(100, 160)]
    assert states[0].names == (*PAIR, *strays[:MOST_LOST])
    assert states[-1].names == (*PAIR, *strays)  # adopted once those are back
    assert (states[-1].status == TRACKED).all()


def test_vehicles_that_were_tracked_or_are_in_the_frame_without_a_position_are_not_forgotten():
    fleet = tuple(f"x{k}" for k in range(60))
    flown, hidden = MocapFilter(IDEAL_SENSING, ()), MocapFilter(IDEAL_SENSING, ())
    for tick in range(200):
        seen = flown.update(_crowd(tick, fleet) if tick < 20 else frame_at(tick))
        there = hidden.update(_crowd(tick, fleet, lost=tick < 150))
        assert seen.names == there.names == (*PAIR, *fleet)
    assert (seen.status[2:] == LOST).all()
    assert (there.status == TRACKED).all()


def test_a_filter_that_refused_names_takes_them_after_a_reset():
    block = MocapFilter(IDEAL_SENSING, ())
    for tick in range(300):
        block.update(_beside_a_marker(tick))
    block.reset()
    assert block.update(_beside_a_marker(300)).names == (*PAIR, "m300")
    assert not block.refuses_names


def test_a_vehicle_that_came_while_many_were_lost_is_adopted_once_they_are_back():
    names = tuple(f"cf{k}" for k in range(MOST_LOST + 1))
    place = np.arange(len(names))[:, None] * [0.5, 0.0, 0.0]
    block = MocapFilter(IDEAL_SENSING, ())

    def fly(ticks: range, seen: slice) -> SwarmState:
        rows = place[seen]
        quat = identity_quat((len(rows),))
        for tick in ticks:
            state = block.update(MocapFrame(time_of(tick), names[seen], rows, quat))
        return state

    fly(range(30), slice(MOST_LOST))
    assert (fly(range(30, 100), slice(0)).status == LOST).all()
    assert fly(range(100, 101), slice(None)).names == names[:MOST_LOST]
    assert block.refuses_names
    state = fly(range(101, 200), slice(None))
    assert state.names == names
    assert (state.status == TRACKED).all()
    assert not block.refuses_names
