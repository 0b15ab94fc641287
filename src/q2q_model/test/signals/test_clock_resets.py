"""Old stamps of which the newest rises are a clock set back; old stamps that come now and then are not."""

import numpy as np

from q2q_model.signals.clock_resets import CONFIRM_STAMPS, ClockResetDetector


def test_stamps_that_rise_for_long_enough_are_a_new_time() -> None:
    old = ClockResetDetector()
    output = [old.confirm_reset(1.0 + k * 0.01) for k in range(13)]
    assert output == [False] * 10 + [True] * 3


def test_few_stamps_are_none_however_far_apart() -> None:
    old = ClockResetDetector()
    assert [old.confirm_reset(t) for t in (0.0, 0.5, 1.0)] == [False] * (CONFIRM_STAMPS - 1) + [True]


def test_a_stamp_older_than_all_begins_again() -> None:
    old = ClockResetDetector()
    for k in range(10):
        assert not old.confirm_reset(1.0 + k * 0.01)
    output = [old.confirm_reset(0.5 + k * 0.01) for k in range(11)]
    assert output == [False] * 10 + [True]


def test_a_stamp_that_repeats_or_is_none_does_not_count() -> None:
    for again in (0.09, float("nan")):
        old = ClockResetDetector()
        for k in range(10):
            assert not old.confirm_reset(k * 0.01)
        assert not old.confirm_reset(again)
        assert old.confirm_reset(0.11)


def test_an_old_frame_that_is_delivered_again_does_not_hide_a_new_time() -> None:
    """One of 4.41 s comes before and after the first one of the new time, 4.01 s."""
    old = ClockResetDetector()
    assert not any(old.confirm_reset(t) for t in (4.41, 4.41, 4.01, *[4.41] * 13))
    output = [old.confirm_reset(4.15 + k * 0.01) for k in range(3)]
    assert output == [False, True, True]


def test_a_late_frame_of_the_time_before_does_not_hide_a_new_time() -> None:
    """Frames of 4.84 and 4.85 s change places, and the clock is set back to 4.41 s between them."""
    old = ClockResetDetector()
    assert not any(old.confirm_reset(t) for t in (4.83, 4.84, 4.41, 4.85, *np.arange(4.42, 4.505, 0.01)))
    assert old.confirm_reset(4.51)


def test_frames_lost_in_a_new_time_beside_the_one_before_do_not_end_it() -> None:
    """Set back by 0.1 s only: after a gap its stamps are nearer to those before, and go on."""
    old = ClockResetDetector()
    assert not any(old.confirm_reset(t) for t in (4.83, 4.84, 4.74, 4.75))
    assert not old.confirm_reset(4.83)
    assert [old.confirm_reset(t) for t in (4.84, 4.85, 4.86)] == [False, True, True]


def test_reordered_stamps_do_not_hide_a_new_time() -> None:
    old = ClockResetDetector()
    late = [
        old.confirm_reset((k - 3 if k % 2 else k) * 0.01) for k in range(20)
    ]  # every second frame is three ticks old
    assert True in late[:13]


def test_a_newer_stamp_between_forgets_them() -> None:
    old = ClockResetDetector()
    for k in range(10):
        old.confirm_reset(k * 0.01)
    old.reset()
    assert not old.confirm_reset(0.1)
