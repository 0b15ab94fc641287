"""End of a recording: what it lacks of the flight, and what that adds to the verdict."""

from dataclasses import replace

import numpy as np

from q2q_model.flights.flight import Flight
from q2q_sim.monitors.flight_verdict import Finding, FlightVerdict, with_finding
from q2q_sim.monitors.metrics.flight_metrics import tick_period

EARLY_S = 0.5
"""Time that a flight to the end may lack [s]: live, the last ticks are lost when the nodes end."""


def with_lost_ticks(verdict: FlightVerdict, flight: Flight, flown: int) -> FlightVerdict:
    """Return a verdict that names how many of the ticks flown the recording lacks."""
    lost = flown - len(flight.t)
    if lost <= 0:
        return verdict
    words = f"{lost} of {flown} ticks missing from the recording"
    return replace(verdict, unjudged=(*verdict.unjudged, words))


def with_end(verdict: FlightVerdict, flight: Flight, planned: str, *, is_cut: bool) -> FlightVerdict:
    """Return the verdict on all of a recording: one that was cut off, or was to last `planned` [s]."""
    return with_unknown_end(verdict, flight) if is_cut else with_planned_end(verdict, flight, planned)


def with_unknown_end(verdict: FlightVerdict, flight: Flight) -> FlightVerdict:
    """Return the verdict on a flight whose recording was cut off, by a kill or a full disk."""
    words = f"the recording was cut off at {flight.t[-1] - flight.t[0]:.1f} s: its end is unknown"
    return with_finding(verdict, Finding(float(flight.t[-1]), words))


def with_planned_end(verdict: FlightVerdict, flight: Flight, planned: str) -> FlightVerdict:
    """Return the verdict on a flight that was to last `planned` [s]; empty or no number is unknown.

    A recording may begin after its flight: a stamp up to the planned end is the time since the start.
    """
    end = float(flight.t[-1])
    try:
        begins_late = end < float(planned) + EARLY_S
    except ValueError:
        return verdict
    flown = max(recorded_duration(flight), end) if begins_late else recorded_duration(flight)
    if not float(planned) - flown > EARLY_S:
        return verdict
    words = f"the flight ended at {flown:.1f} s of {float(planned):.1f} s, before its end"
    return with_finding(verdict, Finding(end, words))


def recorded_duration(flight: Flight) -> float:
    """Return the time of a recording with that of its last tick [s]."""
    tick = tick_period(flight)
    return float(flight.t[-1] - flight.t[0]) + (tick if np.isfinite(tick) else 0.0)
