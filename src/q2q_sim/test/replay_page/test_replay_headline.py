"""The first line of a replay: who was pushed down under another, how far, and when."""

from dataclasses import replace

import numpy as np
import pytest

from q2q_model.flights.flight import Flight
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import CRAZYFLIE_2_0
from q2q_sim.loop.flight_recorder import FlightRecorder
from q2q_sim.replay_page import replay_run

T = 0.02 * np.arange(500)
PASSES = 4.0
"""Time at which the upper vehicle leaves the lower one's downwash [s]."""


def headline(flight: Flight) -> str:
    return replay_run(flight, CRAZYFLIE_2_0).verdict.split(";")[0]


def passed(loss: Array) -> Flight:
    """Return a flight whose lower vehicle loses height, (T,) [m], the upper one above it at first."""
    ref = np.zeros((len(T), 2, 3))
    ref[..., 2] = 1.0, 1.5
    ref[:, 1, 0] = np.where(T <= PASSES, 0.0, 1.0)
    pos = ref.copy()
    pos[:, 0, 2] -= loss
    return replace(FlightRecorder(("cf1", "cf2"), len(T)).flight("made"), t=T, true_pos=pos, ref_pos=ref)


def test_a_sag_that_grows_after_the_pass_is_reported_at_its_deepest() -> None:
    loss = 0.09 * np.exp(-0.5 * ((T - 5.5) / 1.0) ** 2)  # deepest 1.5 s after the pass
    assert headline(passed(loss)) == "cf1 pushed 9 cm down at 5.5 s"


def test_what_a_vehicle_does_once_it_is_back_on_its_reference_is_no_sag() -> None:
    pushed = 0.05 * np.exp(-0.5 * ((T - 3.8) / 0.1) ** 2) - 0.001
    later = np.where(np.abs(T - 6.5) < 0.2, 0.3, 0.0)
    assert headline(passed(pushed + later)) == "cf1 pushed 5 cm down at 3.8 s"


def test_a_sag_long_after_the_pass_is_of_another_cause() -> None:
    pushed = 0.05 * np.exp(-0.5 * ((T - 3.8) / 0.1) ** 2) + 0.001
    later = np.where(T > PASSES + 3.5, 0.3, 0.0)
    assert headline(passed(pushed + later)) == "cf1 pushed 5 cm down at 3.8 s"


def test_without_a_reference_no_depth_of_a_vehicle_under_another_is_claimed() -> None:
    flight = passed(np.full(len(T), 0.2))
    bare = replace(flight, ref_pos=np.full_like(flight.ref_pos, np.nan))
    assert headline(bare) == "1 vehicle flew under another, without a reference for the height loss"


@pytest.mark.parametrize("aside", [1.0, 0.2])
def test_vehicles_beside_each_other_pass_under_none(aside: float) -> None:
    flight = passed(np.zeros(len(T)))
    beside = flight.true_pos + np.array([[[0.0, 0.0, 0.0], [aside, 0.0, 0.0]]])
    assert headline(replace(flight, true_pos=beside)) == "no vehicle passed under another"
