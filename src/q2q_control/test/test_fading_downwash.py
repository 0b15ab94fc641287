"""What is left of a downwash while a vehicle has no measurements."""

import numpy as np
import pytest

from q2q_control.failsafe.fading_downwash import REACH, WIDTH, FadingDownwash


def places(**at: tuple[float, float, float]) -> dict[str, np.ndarray]:
    return {name: np.array(pos) for name, pos in at.items()}


def test_it_fades_as_those_above_move_and_not_by_time_or_by_a_common_motion() -> None:
    fading = FadingDownwash()
    begun = places(low=(0.0, 0.0, 1.0), high=(0.05, 0.0, 1.5), far=(REACH, 0.1, 1.5), below=(0.0, 0.0, 0.5))
    assert fading.shares(["low"], [], begun) == {"low": 1.0}
    together = {name: pos + np.array([3.0, -1.0, 0.2]) for name, pos in begun.items()}
    for _ in range(100):
        assert fading.shares(["low"], [], together) == {"low": 1.0}
    for others in ("far", "below"):
        assert fading.shares(["low"], [], together | {others: np.zeros(3)}) == {"low": 1.0}
    moved = together | {"high": together["high"] + np.array([0.0, WIDTH, 0.0])}
    assert fading.shares(["low"], [], moved)["low"] == pytest.approx(np.exp(-1.0))
    assert fading.shares(["low"], [], together) == {"low": 1.0}  # back again


def test_of_two_above_the_one_that_stays_keeps_its_half() -> None:
    fading = FadingDownwash()
    begun = places(low=(0.0, 0.0, 1.0), middle=(0.0, 0.0, 1.5), high=(0.0, 0.0, 2.0))
    fading.shares(["low"], [], begun)
    left = begun | places(middle=(1.0, 0.0, 1.5))
    assert fading.shares(["low"], [], left)["low"] == pytest.approx(0.5)
    del left["middle"]
    assert fading.shares(["low"], [], left)["low"] == pytest.approx(0.5)


def test_a_prediction_that_follows_the_vehicle_does_not_fade_and_begins_anew_where_it_ends() -> None:
    fading = FadingDownwash()
    begun = places(low=(0.0, 0.0, 1.0), high=(0.0, 0.0, 1.5))
    fading.shares(["low"], ["low"], begun)
    moved = begun | places(high=(0.1, 0.0, 1.5))
    assert fading.shares(["low"], ["low"], moved) == {"low": 1.0}
    assert fading.shares(["low"], [], moved) == {"low": 1.0}
    assert fading.shares(["low"], [], begun)["low"] == pytest.approx(np.exp(-((0.1 / WIDTH) ** 2)))


def test_who_is_measured_again_begins_anew_and_nobody_above_leaves_all() -> None:
    fading = FadingDownwash()
    begun = places(low=(0.0, 0.0, 1.0), high=(0.0, 0.0, 1.5))
    fading.shares(["low"], [], begun)
    assert fading.shares([], [], begun) == {}
    moved = begun | places(high=(0.2, 0.0, 1.5))
    assert fading.shares(["low"], [], moved) == {"low": 1.0}
    assert FadingDownwash().shares(["high"], [], begun) == {"high": 1.0}
