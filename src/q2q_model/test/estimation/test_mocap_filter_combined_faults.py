"""Faults that come together: swapped markers of which one was moved, a frozen outlier; a clock set back."""

import numpy as np
import pytest

from q2q_model.estimation.mocap_filter import MocapFilter
from q2q_model.estimation.mocap_filter_params import MocapFilterParams
from q2q_model.signals.values import Array, MocapFrame, Names, TrackStatus

PAIR: Names = ("cf1", "cf2")
TICK = 0.01
TRACKED = TrackStatus.TRACKED
NOISE = 2e-4
"""[m]: VICON's, so that no pose is the last one again by chance."""


def truth(tick: int) -> Array:
    """Return one vehicle that hovers, and one that passes 0.5 m above at 0.5 m/s."""
    return np.array([[0.0, 0.0, 1.0], [-0.5 + 0.5 * tick * TICK, 0.1, 1.5]])


def frame(tick: int, pos: Array, t: float | None = None) -> MocapFrame:
    noise = NOISE * np.random.default_rng(tick).standard_normal(pos.shape)
    return MocapFrame(
        tick * TICK if t is None else t, PAIR, pos + noise, np.tile([0.0, 0.0, 0.0, 1.0], (2, 1))
    )


def flown(ticks: int, offset: float = 0.0) -> MocapFilter:
    """Return a filter that has seen so many ticks, the first vehicle's marker moved by an offset [m]."""
    block, moved = MocapFilter(MocapFilterParams(), PAIR), np.array([[offset, 0.0, 0.0], [0.0, 0.0, 0.0]])
    for tick in range(ticks):
        block.update(frame(tick, truth(tick) + moved))
    return block


@pytest.mark.parametrize("offset", [0.04, 0.07, 0.13, 0.3])
@pytest.mark.parametrize("length", [4, 8, 20])
def test_a_swap_of_a_marker_that_was_moved_is_never_accepted(offset: float, length: int) -> None:
    block = flown(100, offset)
    moved = np.array([[offset, 0.0, 0.0], [0.0, 0.0, 0.0]])
    for tick in range(100, 100 + length):
        state = block.update(frame(tick, truth(tick)[::-1] + moved))
        wrong = np.linalg.norm(state.pos - truth(tick) - moved, axis=1) > 0.1 + offset
        assert not (wrong & (state.status == TRACKED)).any()
    for tick in range(100 + length, 110 + length):
        state = block.update(frame(tick, truth(tick) + moved))
    assert list(state.status) == [TRACKED, TRACKED]
    np.testing.assert_allclose(state.pos, truth(tick) + moved, atol=5e-3)


@pytest.mark.parametrize("length", [4, 12, 30])
def test_an_outlier_that_freezes_is_no_jump(length: int) -> None:
    block = flown(100)
    outlier = frame(100, truth(100) + np.array([[1.0, 0.5, 1.0], [0.0, 0.0, 0.0]]))
    for tick in range(100, 100 + length):
        state = block.update(MocapFrame(tick * TICK, PAIR, outlier.pos, outlier.quat))
        assert state.status[0] != TRACKED
    state = block.update(frame(100 + length, truth(100 + length)))
    np.testing.assert_allclose(state.pos[0], truth(0)[0], atol=5e-3)
    assert state.status[0] == TRACKED


@pytest.mark.parametrize("back", [0.2, 0.48, 0.9])
def test_a_clock_that_is_set_back_is_followed_within_0_12_s(back: float) -> None:
    block = flown(200)
    output = []
    for tick in range(200, 220):
        state = block.update(frame(tick, truth(tick), tick * TICK - back))
        followed = block.report.clock_resets == 1 and list(state.status) == [TRACKED, TRACKED]
        output.append(followed and bool(np.abs(state.pos - truth(tick)).max() < 5e-3))
    assert output.index(True) <= 12
    assert all(output[output.index(True) :])
    assert block.report.clock_resets == 1
    np.testing.assert_allclose(state.pos, truth(219), atol=5e-3)


def test_frames_that_come_late_now_and_then_set_no_clock_back() -> None:
    block = flown(200)
    for tick in range(200, 260):
        block.update(frame(tick, truth(tick)))
        for late in range(tick - 10, tick):
            state = block.update(frame(late, truth(late)))
            np.testing.assert_allclose(state.pos, truth(tick), atol=5e-3)
    assert block.report.clock_resets == 0


def test_a_flipped_attitude_that_freezes_does_not_last() -> None:
    block, over = flown(100), np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
    for tick in range(100, 160):
        now = min(tick, 110)  # then the last frame again under new stamps
        state = block.update(MocapFrame(tick * TICK, PAIR, frame(now, truth(now)).pos, over))
        np.testing.assert_allclose(state.quat[0], [0.0, 0.0, 0.0, 1.0], atol=1e-12)


@pytest.mark.parametrize("length", [2, 10, 30])
def test_a_vehicle_seen_once_is_not_where_its_label_is_at_another_that_is_missing(length: int) -> None:
    block, gone = flown(1), np.array([[0.0] * 3, [np.nan] * 3])
    for tick in range(1, 100):
        block.update(frame(tick, truth(0) + gone))
    for tick in range(100, 100 + length):  # cf1 carries the label of cf2
        state = block.update(frame(tick, truth(0)[::-1] + gone[::-1]))
        np.testing.assert_allclose(state.pos[0], truth(0)[0], atol=5e-3)
        assert state.status[1] != TRACKED
    state = block.update(frame(100 + length, truth(0)))
    assert state.status[0] == TRACKED


@pytest.mark.parametrize("first", [0, 1])
def test_outliers_in_every_third_frame_from_the_start_are_rejected(first: int) -> None:
    block, off = MocapFilter(MocapFilterParams(), PAIR), np.array([[2.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    for tick in range(60):
        wrong = tick % 3 == first
        state = block.update(frame(tick, truth(tick) + off * wrong))
        if tick > first + 3:
            np.testing.assert_allclose(state.pos, truth(tick), atol=5e-3)
            assert (state.status[0] == TRACKED) != wrong
    assert block.report.refused == 19
