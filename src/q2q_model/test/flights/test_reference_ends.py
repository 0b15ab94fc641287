"""The last reference of a bag of other software: that of a stream ends, a goal holds."""

from collections.abc import Sequence

import numpy as np
import pytest
from moving_poses import flown

TICKS = 5.0 + np.arange(2000) / 100.0
BEGIN = 12.0
"""Time of the second reference [s]: a hover is held until then."""


def last_reference(places: Sequence[float], period: float) -> float:
    """Return the time after the last message until which a flight has a reference [s]."""
    t = np.concatenate([[TICKS[0]], BEGIN + period * np.arange(len(places) - 1)])
    found, _ = flown(TICKS, t, np.outer(places, [1.0, 0.0, 0.0]))
    return float(found.t[np.isfinite(found.ref_pos[:, 0, 0])][-1] - t[-1])


@pytest.mark.parametrize(
    "places",
    [
        (*range(9), 8),
        (*range(9), *[8] * 30),
        tuple(np.repeat(np.arange(9), 2)),
        tuple(
            (1.0 - np.linspace(1.0, 0.0, 25) ** 5).astype(np.float32)
        ),  # the last moves are below its resolution
    ],
    ids=["last sample again", "at rest", "each position twice", "float32"],
)
def test_a_short_stream_that_ends_at_rest_is_no_goal(places: Sequence[float]) -> None:
    assert last_reference(places, 0.05) == pytest.approx(0.15, abs=0.011)  # a tick


def test_three_goals_of_keys_are_no_stream() -> None:
    assert last_reference((0.0, 0.1, 0.2, 0.3), 0.2) > 12.0


def test_references_that_have_ended_are_not_held_for_ever() -> None:
    ticks = 5.0 + np.arange(1000) / 100.0
    flight, remarks = flown(ticks, 5.0 + np.arange(500) / 100.0)  # a stream: three periods of it
    known = np.isfinite(flight.ref_pos[:, 0]).all(axis=1)
    assert ticks[known][-1] == pytest.approx(9.99 + 0.03, abs=1e-6)
    assert remarks == ["references of cf1 end at t = 9.990 s, 5.0 s before the poses: none after 10.020 s"]
    thrice, remarks = flown(ticks, np.repeat(5.0 + np.arange(500) / 100.0, 3))  # each stamp three times
    np.testing.assert_array_equal(thrice.ref_pos, flight.ref_pos)
    assert remarks[0].endswith("none after 10.020 s")


@pytest.mark.parametrize("goals", [[5.0], [5.0, 5.01, 5.02], [3.0, 5.9, 8.8], [5.0, 5.01, 8.0, 8.01, 8.02]])
def test_the_last_goal_holds_to_the_end_of_the_poses(goals: list[float]) -> None:
    """A vehicle that hovers is sent one, once or several times in a row."""
    ticks = 5.0 + np.arange(1000) / 100.0
    flight, remarks = flown(ticks, np.array(goals))
    assert np.isfinite(flight.ref_pos).all()
    assert flight.ref_pos[-1, 0, 0] == goals[-1]
    ends = f"references of cf1 end at t = {goals[-1]:.3f} s, {14.99 - goals[-1]:.1f} s before the poses"
    assert remarks == [f"{ends}: the last is held"]


@pytest.mark.parametrize("seconds", [0.4, 1.2])
def test_a_short_stream_that_moves_is_no_goal(seconds: float) -> None:
    """It may follow a pause in which a hover is held."""
    ticks = 5.0 + np.arange(2000) / 100.0
    stream = 12.0 + np.arange(round(seconds * 20) + 1) / 20.0
    flight, remarks = flown(ticks, np.concatenate([[5.0, 5.01], stream]))
    known = np.isfinite(flight.ref_pos[:, 0]).all(axis=1)
    assert ticks[known][-1] == pytest.approx(12.0 + seconds + 0.15, abs=1e-6)
    assert remarks[-1].endswith(f"none after {12.15 + seconds:.3f} s")


def test_references_that_end_shortly_before_the_poses_are_not_told() -> None:
    assert flown(5.0 + np.arange(1000) / 100.0, np.array([3.0, 7.0, 12.5]))[1][1:] == []
