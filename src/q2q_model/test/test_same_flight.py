"""Flights that a model or an air was fitted to."""

from dataclasses import replace

from made_flights import Pass, made_flight

from q2q_model.flights.same_flight import COPY_IN_FIT, IN_FIT, fit_remarks, flight_digest


def test_a_flight_is_known_by_its_contents_under_any_name_and_doubted_by_its_name() -> None:
    flight = made_flight(Pass(seconds=2.0))
    moved = replace(flight, mocap_pos=flight.mocap_pos + 1e-6)
    files = ["room/pass"], [flight_digest(flight)]
    named = {"new": replace(flight, name="new"), "pass": moved, "else": replace(moved, name="else")}
    assert fit_remarks(named.values(), *files) == {"new": COPY_IN_FIT, "pass": IN_FIT}
    assert fit_remarks([flight], files[0], []) == {"pass": IN_FIT}
