"""What vehicles fly between two ticks is shown by stamps, but for leaps of the clock."""

import pytest

from q2q_control.failsafe.tracking_loss.elapsed_time import GAP_S, LONGEST_STEP, ElapsedTime
from q2q_model.signals.stamps import TICK_S


def flown(steps: list[float]) -> list[float]:
    """Return what is flown in steps of frames [s]; a step of 0 is a frame that is not newer."""
    time, found = ElapsedTime(), []
    for step in steps:
        if step == 0.0:
            time.wait()
        found.append(time.update(step, by_frame=True) if step else 0.0)
    return found


@pytest.mark.parametrize("step", [TICK_S, 0.004, 0.1, 0.3])
def test_steps_of_any_rate_are_flown_as_told(step: float) -> None:
    assert flown([step] * 5)[1:] == [step] * 4


def test_a_single_missing_frame_of_a_slow_camera_is_flown() -> None:
    assert flown([0.1, 0.1, 0.2, 0.1])[2:] == [pytest.approx(0.2), pytest.approx(0.1)]
    assert flown([0.1, 0.1, 0.21])[2:] == [pytest.approx(0.1)]


@pytest.mark.parametrize("ahead", [0.06, 0.34, 5.0, 3600.0])
def test_a_clock_set_ahead_is_flown_as_one_tick(ahead: float) -> None:
    assert flown([TICK_S, ahead + TICK_S, TICK_S]) == pytest.approx([TICK_S] * 3)


def test_a_leap_after_late_frames_is_flown_for_as_long_as_they_were_late() -> None:
    """Frames come 0.08 s late for 0.2 s and are in time at once: all is flown once, however long it took."""
    steps = [TICK_S] * 3 + [0.0] * 8 + [TICK_S] * 12 + [TICK_S + 0.08] + [TICK_S] * 3
    assert flown(steps) == pytest.approx(steps)


def test_a_clock_set_ahead_while_frames_are_late_is_told_from_them() -> None:
    steps = [TICK_S] * 3 + [0.0] * 8 + [TICK_S + 0.34 + 0.08, TICK_S]
    assert flown(steps)[-2:] == pytest.approx([TICK_S + 0.08, TICK_S])


def test_frames_that_overtake_each_other_leave_nothing_for_a_leap() -> None:
    assert flown([0.02, 0.0] * 50 + [0.5])[-1] == pytest.approx(0.02 + TICK_S)


def test_what_a_timer_counted_is_flown_up_to_what_the_filter_coasts() -> None:
    assert ElapsedTime().update(GAP_S + 0.1, by_frame=False) == GAP_S + 0.1
    assert ElapsedTime().update(1.0, by_frame=False) == LONGEST_STEP


def test_a_timer_that_counted_late_frames_leaves_none_of_them_for_a_leap() -> None:
    time = ElapsedTime()
    for _ in range(11):
        time.wait()
    assert time.update(0.11, by_frame=False) == 0.11
    assert time.update(TICK_S, by_frame=True) == TICK_S
    assert time.update(0.5, by_frame=True) == pytest.approx(2 * TICK_S)
