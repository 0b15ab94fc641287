"""What is left of a downwash while a vehicle has no measurements."""

import numpy as np
import pytest

from q2q_control.failsafe.tracking_loss.dead_reckoning import OBSERVER
from q2q_control.failsafe.tracking_loss.fading_downwash import (
    ABOVE_RADIUS,
    FADE_S,
    JET_WIDTH,
    FadingDownwash,
    Places,
)

LOW = np.array([0])
"""Row of the vehicle without measurements."""
BEGUN = {
    "low": (0.0, 0.0, 1.0),
    "high": (0.05, 0.0, 1.5),
    "far": (ABOVE_RADIUS, 0.1, 1.5),
    "below": (0.0, 0.0, 0.5),
}


def places(at: dict[str, tuple[float, float, float]], shift: tuple[float, ...] = (0.0, 0.0, 0.0)) -> Places:
    return Places(tuple(at), np.array(list(at.values())) + shift)


def left(fading: FadingDownwash, at: Places, known: bool = False, t: float = 0.0) -> float:
    return float(fading.shares(LOW, np.array([known]), at, t)[0])


def test_it_fades_as_those_above_move_and_not_by_a_common_motion() -> None:
    fading, shift = FadingDownwash(), (3.0, -1.0, 0.2)
    assert left(fading, places(BEGUN)) == 1.0
    for _ in range(100):
        assert left(fading, places(BEGUN, shift)) == pytest.approx(1.0)
    for others in ("far", "below"):
        assert left(fading, places(BEGUN | {others: (9.0, 9.0, 9.0)}, shift)) == pytest.approx(1.0)
    moved = BEGUN | {"high": (0.05, JET_WIDTH, 1.5)}
    assert left(fading, places(moved)) == pytest.approx(np.exp(-1.0))
    assert left(fading, places(BEGUN)) == 1.0  # back again


def test_it_fades_with_the_time_since_it_was_known_where_somebody_is_above() -> None:
    fading = FadingDownwash()
    assert left(fading, places(BEGUN), known=True, t=1.0) == 1.0
    assert left(fading, places(BEGUN), t=1.0 + FADE_S) == pytest.approx(np.exp(-1.0))
    assert left(fading, places(BEGUN), known=True, t=3.0) == 1.0
    alone, below = FadingDownwash(), {"low": BEGUN["low"], "below": BEGUN["below"]}
    assert left(alone, places(below), t=1.0) == left(alone, places(below), t=9.0) == 1.0


def test_one_that_left_a_moment_ago_counts_as_above_by_the_downwash_that_the_trim_still_holds() -> None:
    at = BEGUN | {"high": (0.25 + 0.8 * 2.0 / OBSERVER[1] - 0.01, 0.0, 1.5)}
    fading = FadingDownwash()
    assert left(fading, places(at)) == 1.0
    assert left(fading, places(at), t=FADE_S) == pytest.approx(np.exp(-1.0))


def test_of_two_above_the_one_that_stays_keeps_its_half() -> None:
    fading, begun = FadingDownwash(), BEGUN | {"middle": (0.0, 0.0, 1.2)}
    left(fading, places(begun))
    assert left(fading, places(begun | {"middle": (1.0, 0.0, 1.2)})) == pytest.approx(0.5)
    assert left(fading, places(BEGUN)) == pytest.approx(0.5)  # the middle one is not there


def test_a_prediction_that_follows_the_vehicle_does_not_fade_and_begins_anew_where_it_ends() -> None:
    fading, moved = FadingDownwash(), BEGUN | {"high": (0.15, 0.0, 1.5)}
    left(fading, places(BEGUN), known=True)
    assert left(fading, places(moved), known=True) == 1.0
    assert left(fading, places(moved)) == 1.0
    assert left(fading, places(BEGUN)) == pytest.approx(np.exp(-((0.1 / JET_WIDTH) ** 2)))


def test_who_is_measured_again_begins_anew_and_nobody_above_leaves_all() -> None:
    fading, nobody = FadingDownwash(), np.zeros(0, dtype=np.intp)
    left(fading, places(BEGUN))
    assert fading.shares(nobody, np.zeros(0, np.bool_), places(BEGUN), 0.0).size == 0
    assert left(fading, places(BEGUN | {"high": (0.2, 0.0, 1.5)})) == 1.0
    alone = {"low": BEGUN["low"], "below": BEGUN["below"]}
    assert left(FadingDownwash(), places(alone)) == 1.0


def test_a_clock_that_is_set_back_moves_the_time_since_it_was_known() -> None:
    fading = FadingDownwash()
    left(fading, places(BEGUN), known=True, t=1.0)
    fading.set_back(0.4)
    assert left(fading, places(BEGUN), t=0.6 + FADE_S) == pytest.approx(np.exp(-1.0))


def test_vehicles_that_come_and_go_leave_the_others_as_they_were() -> None:
    fading, moved = FadingDownwash(), BEGUN | {"high": (0.05, JET_WIDTH, 1.5)}
    left(fading, places(BEGUN))
    fewer = {name: moved[name] for name in ("low", "below", "high")} | {"new": (0.0, 0.0, 2.0)}
    assert left(fading, places(fewer)) == pytest.approx(np.exp(-1.0))
    assert left(fading, places({name: moved[name] for name in ("low", "far")})) == 0.0  # "high" has left


def test_many_fade_as_each_would_alone() -> None:
    rng = np.random.default_rng(3)
    names, every = tuple(f"cf{k}" for k in range(12)), np.arange(12)
    together, alone = FadingDownwash(), [FadingDownwash() for _ in names]
    for tick in range(6):
        at = Places(names, rng.uniform(0.0, 0.5, (12, 3)))
        known, t = rng.random(12) < 0.3, 0.1 * tick
        apart = [one.shares(every[[k]], known[[k]], at, t)[0] for k, one in enumerate(alone)]
        np.testing.assert_allclose(together.shares(every, known, at, t), apart, rtol=1e-12)


def test_a_clock_set_back_or_a_new_vehicle_after_a_prediction_changes_nothing() -> None:
    back, more = FadingDownwash(), FadingDownwash()
    for fading in (back, more):
        left(fading, places(BEGUN), known=True, t=5.0)
    back.set_back(3.0)
    assert left(back, places(BEGUN), t=2.0 + FADE_S) == pytest.approx(np.exp(-1.0))
    moved = {"new": (5.0, 5.0, 1.0)} | BEGUN | {"high": (0.05, JET_WIDTH, 1.5)}
    shares = more.shares(np.array([1]), np.zeros(1, np.bool_), places(moved), 5.0)
    assert shares[0] == pytest.approx(np.exp(-1.0))
