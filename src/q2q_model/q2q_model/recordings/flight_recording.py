"""Recording: a flight with its log, as read from a bag or a table."""

from dataclasses import dataclass

from q2q_model.flights.flight import Flight
from q2q_model.flights.flight_log import FlightLog


@dataclass(frozen=True, slots=True)
class Recording:
    """Flight read from a bag or a table, with its log."""

    flight: Flight
    log: FlightLog | None = None
    """At the ticks and vehicles of the flight."""
    filtered: bool = False
    """Whether no states were recorded, and those of the flight are of the mocap filter."""
    model: str = ""
    """Interaction model of the controller, by name or path; empty where unknown."""
