"""Old stamps that rise are a clock set back; old stamps that come now and then, or out of order, are not."""

from q2q_model.estimation.clock_resets import CONFIRM_STAMPS, ClockResetDetector


def test_stamps_that_rise_for_long_enough_are_a_new_time() -> None:
    old = ClockResetDetector()
    output = [old.rise(1.0 + k * 0.01) for k in range(13)]
    assert output == [False] * 10 + [True] * 3


def test_few_stamps_are_none_however_far_apart() -> None:
    old = ClockResetDetector()
    assert [old.rise(t) for t in (0.0, 0.5, 1.0)] == [False] * (CONFIRM_STAMPS - 1) + [True]


def test_a_stamp_that_falls_or_repeats_or_is_none_begins_again() -> None:
    for again in (0.02, 0.09, float("nan")):
        old = ClockResetDetector()
        for k in range(10):
            assert not old.rise(k * 0.01)
        assert not old.rise(again)
        assert not old.rise(0.11)


def test_a_newer_stamp_between_forgets_them() -> None:
    old = ClockResetDetector()
    for k in range(10):
        old.rise(k * 0.01)
    old.reset()
    assert not old.rise(0.1)
