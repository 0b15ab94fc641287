"""Simulated flights of one seed share their noise, and are flights of their own; a copy is refused."""

import shutil
from pathlib import Path

import pytest

import q2q
from q2q_model.bag import BagError
from q2q_model.recordings.recordings_of_bags import recordings_of_bags


def under(gap: float, *, aware: bool) -> q2q.FlightResult:
    """Return a flight of 12 s in which a vehicle passes another at a height `gap` [m] above it."""
    passing = {
        "wake": "measured",
        "model": "measured_law",
        "room": "real",
        "vehicles": {
            "low": [{"t": 0.0, "pos": [0.0, 0.0, 1.0]}, {"t": 12.0, "pos": [0.0, 0.0, 1.0]}],
            "up": [{"t": 0.0, "pos": [-1.0, 0.0, 1.0 + gap]}, {"t": 12.0, "pos": [1.0, 0.0, 1.0 + gap]}],
        },
    }
    return q2q.fly(q2q.scenario(passing), aware=aware)


def test_gaps_and_controllers_flown_with_one_seed_are_flights_of_their_own(tmp_path: Path) -> None:
    flights = {
        "near": under(0.4, aware=True),
        "far": under(0.6, aware=True),
        "ignoring": under(0.4, aware=False),
    }
    bags = [flight.to_bag(tmp_path / name) for name, flight in flights.items()]
    recordings, _ = recordings_of_bags(bags)
    assert [one.flight.name for one in recordings] == list(flights)
    copy = shutil.copytree(bags[0], tmp_path / "copy")
    with pytest.raises(BagError, match=r"near and .*copy contain the same flight"):
        recordings_of_bags([*bags, copy])
