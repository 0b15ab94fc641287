"""The last reference of a bag of other software: that of a stream ends, a goal holds."""

from collections.abc import Sequence

import numpy as np
import pytest

from q2q_model.bag.foreign.pose_frames import Poses, pose_frames
from q2q_model.bag.foreign.references import References, with_references
from q2q_model.flights.joined_flight import flight_from_signals

TICKS = 5.0 + np.arange(2000) / 100.0
BEGIN = 12.0
"""Time of the second reference [s]: a hover is held until then."""


def last_reference(places: Sequence[float], period: float) -> float:
    """Return the time after the last message until which a flight has a reference [s]."""
    t = np.concatenate([[TICKS[0]], BEGIN + period * np.arange(len(places) - 1)])
    pos, unknown = np.zeros((len(t), 3)), np.full((len(t), 3), np.nan)
    pos[:, 0] = places
    poses = Poses(TICKS, np.zeros((len(TICKS), 3)), np.full((len(TICKS), 4), np.nan), 0.0)
    flight = flight_from_signals("made", {"mocap": pose_frames({"cf1": poses}, 0.005)[0]}).flight
    found, _ = with_references(flight, {"cf1": References(t, pos, unknown, unknown)})
    return float(found.t[np.isfinite(found.ref_pos[:, 0, 0])][-1] - t[-1])


@pytest.mark.parametrize(
    "places",
    [
        (*range(9), 8),
        (*range(9), *[8] * 30),
        tuple(np.repeat(np.arange(9), 2)),
        tuple(np.float32(1.0 - np.linspace(1.0, 0.0, 25) ** 5)),  # the last moves are below its resolution
    ],
    ids=["last sample again", "at rest", "each position twice", "float32"],
)
def test_a_short_stream_that_ends_at_rest_is_no_goal(places: Sequence[float]) -> None:
    assert last_reference(places, 0.05) == pytest.approx(0.15, abs=0.011)  # a tick


def test_three_goals_of_keys_are_no_stream() -> None:
    assert last_reference((0.0, 0.1, 0.2, 0.3), 0.2) > 12.0
