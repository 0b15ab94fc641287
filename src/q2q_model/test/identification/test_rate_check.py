"""Angular rates that contradict attitudes are reported."""

import re
from dataclasses import replace

import numpy as np
import pytest
from made_flights import Pass, made_flight
from scipy.spatial.transform import Rotation

from q2q_model.flights.flight import Flight
from q2q_model.identification.push.rate_check import rate_notes


@pytest.fixture(scope="module")
def turning() -> Flight:
    """Return a flight whose first vehicle rolls and pitches at up to 0.4 rad/s, with noise of 1 mrad."""
    flight = made_flight(Pass(seconds=16.0))
    t, rng = flight.t, np.random.default_rng(1)
    rotvec = np.stack([0.2 * np.sin(2.0 * t), 0.1 * np.sin(3.0 * t), np.zeros_like(t)], axis=1)
    turns = Rotation.from_rotvec(rotvec)
    rate = np.zeros((t.size, 3))
    rate[:-1] = (turns[:-1].inv() * turns[1:]).as_rotvec() / np.diff(t)[:, None]
    quat, gyro = flight.mocap_quat.copy(), np.zeros_like(flight.gyro_body)
    quat[:, 0] = (turns * Rotation.from_rotvec(1e-3 * rng.standard_normal((t.size, 3)))).as_quat()
    gyro[:, 0] = rate
    return replace(flight, mocap_quat=quat, gyro_body=gyro)


def test_rates_of_the_attitude_give_no_note(turning: Flight) -> None:
    assert rate_notes([turning]) == []


@pytest.mark.parametrize(
    ("scale", "shown"), [(57.3, "5[0-9].* to 5"), (-1.0, "-1.0. to -"), (0.5, "0.(49|50) to 0.5")]
)
def test_rates_of_another_unit_or_sign_are_reported(turning: Flight, scale: float, shown: str) -> None:
    (note,) = rate_notes([replace(turning, gyro_body=scale * turning.gyro_body)])
    assert "for 1 of 1 vehicles of flights" in note  # the other one does not turn
    assert re.search(f"are {shown}", note)


def test_a_conjugated_attitude_is_reported(turning: Flight) -> None:
    conjugated = turning.mocap_quat * np.array([-1.0, -1.0, -1.0, 1.0])
    assert "body to world" in rate_notes([replace(turning, mocap_quat=conjugated)])[0]


def test_a_flight_without_rates_or_of_a_few_rows_is_not_judged(turning: Flight) -> None:
    assert rate_notes([replace(turning, gyro_body=np.full_like(turning.gyro_body, np.nan))]) == []
