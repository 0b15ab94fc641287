"""Flights of two controllers, identified together, have no gains in common."""

from dataclasses import replace

import pytest
from made_flights import Pass, made_flight

from q2q_model.identification.gains import gain_agreement
from q2q_model.identification.identification import ProcedureParams, identify
from q2q_model.identification.statistics.intervals import Interval
from q2q_model.recordings.flight_recording import Recording
from q2q_model.vehicle.altitude_loop import AltitudeLoop
from q2q_model.vehicle.constants import CRAZYFLIE_2_0, CRAZYFLIE_2_1

SOFT = Pass(
    "soft", loop=AltitudeLoop(10.0, 5.0, lag=CRAZYFLIE_2_0.thrust_lag), start=0.3, noise=1e-4, gust=0.1
)
STIFF = replace(SOFT, name="stiff", loop=replace(SOFT.loop, k_p=20.0, k_d=10.0))


def test_gains_that_differ_are_said_by_flight_and_are_not_in_the_model() -> None:
    flights = [Recording(made_flight(one)) for one in (SOFT, STIFF)]
    found = identify(flights, ProcedureParams(model_type="jet"), lambda _: None)
    (note,) = (one for one in found.remarks if "flown with different gains" in one)
    assert "in soft and K_p 20" in note
    assert found.file.gains is None


def test_every_pair_of_flights_is_compared(monkeypatch: pytest.MonkeyPatch) -> None:
    """A and B do not overlap and are alike, A and C differ by a half; C's interval begins below B's."""
    gains = {"a": (1.0, 0.95, 1.05), "b": (1.15, 1.14, 1.16), "c": (1.5, 1.1, 1.9)}
    each = [gain_agreement.FlightGain(name, "K_d", Interval(*one)) for name, one in gains.items()]
    monkeypatch.setattr(gain_agreement, "_gains_by_flight", lambda _: each)
    assert gain_agreement.differing_gains([]) == (each[0], each[2])
    monkeypatch.setattr(gain_agreement, "_gains_by_flight", lambda _: each[:2])
    assert gain_agreement.differing_gains([]) is None


def test_flights_of_one_controller_keep_their_gains() -> None:
    other = replace(SOFT, name="again", start=0.0, gap=0.4)
    flights = [Recording(made_flight(one)) for one in (SOFT, other)]
    found = identify(flights, ProcedureParams(model_type="jet"), lambda _: None)
    assert not any("different gains" in one for one in found.remarks)
    assert found.file.gains is not None
    assert found.file.gains.k_p == pytest.approx(10.0, rel=0.02)  # as the intervals


def test_gains_by_the_mass_of_another_vehicle_are_not_compared() -> None:
    """Only the weight is said: its remedy comes first, and by the right mass the gains are compared."""
    flights = [Recording(made_flight(one)) for one in (SOFT, STIFF)]
    found = identify(flights, ProcedureParams(model_type="jet", vehicle=CRAZYFLIE_2_1), lambda _: None)
    assert found.remarks[0].startswith("the commanded thrust carries 34.0 g")
    assert not any("different gains" in one for one in found.remarks)
