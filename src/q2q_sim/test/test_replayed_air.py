"""The air of a replay pushes only vehicles under others."""

from dataclasses import replace

import numpy as np
import pytest

from q2q_model.flights.flight import Flight
from q2q_model.vehicle.constants import CRAZYFLIE_2_0
from q2q_sim.loop.recording import FlightRecording
from q2q_sim.replay_page import replay_run

T = 0.01 * np.arange(100, dtype=np.float64)
GUST = np.array([0.3, 0.0, -0.5])


def flown(cf2: tuple[float, float, float]) -> Flight:
    """Return a flight of cf1 at a height of 1 m, and cf2."""
    empty = FlightRecording(("cf1", "cf2"), len(T)).flight("made")
    pos = np.tile([(0.0, 0.0, 1.0), cf2], (len(T), 1, 1))
    return replace(empty, t=T, true_pos=pos)


@pytest.mark.parametrize(
    ("cf2", "is_under"),
    [((0.3, 0.0, 1.5), True), ((0.5, 0.0, 1.5), False), ((0.0, 0.0, 2.6), False), ((9.0, 9.0, 1.0), False)],
)
def test_the_push_of_the_air_is_shown_on_vehicles_under_another(
    cf2: tuple[float, float, float], is_under: bool
) -> None:
    flight = replace(flown(cf2), true_eta=np.full((len(T), 2, 3), GUST))
    found = replay_run(flight, CRAZYFLIE_2_0).downwash
    np.testing.assert_array_equal(found[:, 0], np.tile(GUST if is_under else 0.0 * GUST, (len(T), 1)))
    assert not found[:, 1].any()


def test_a_prediction_is_of_downwash_and_shown_as_it_is() -> None:
    predicted = np.full((len(T), 2, 3), [0.0, 0.0, -0.01])
    run = replay_run(replace(flown((9.0, 9.0, 1.0)), eta=predicted), CRAZYFLIE_2_0)
    np.testing.assert_array_equal(run.downwash, predicted)
