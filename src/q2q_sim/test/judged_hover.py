"""A hover of two vehicles, what may happen in it, and the verdict on it in words."""

from dataclasses import replace

import numpy as np

from q2q_model.flights.flight import Flight
from q2q_model.signals.values import Array
from q2q_sim.loop.flight_recorder import FlightRecorder
from q2q_sim.monitors.flight_judgement import verdict_of
from q2q_sim.monitors.policies import Circumstances

TICKS = 1000
T = 0.01 * np.arange(TICKS)
HOVER = np.broadcast_to([[0.0, 0.0, 1.0], [0.0, 1.0, 1.0]], (TICKS, 2, 3))
AROUND = Circumstances()


def flown(true_pos: Array = HOVER, ref_pos: Array = HOVER, status: Array | None = None) -> Flight:
    """Return a flight of two vehicles over 10 s."""
    empty = FlightRecorder(("cf1", "cf2"), TICKS).flight("made")
    given = np.zeros((TICKS, 2)) if status is None else status
    return replace(empty, t=T, true_pos=true_pos, ref_pos=ref_pos, command_status=given)


def moved(since: float, until: float, vehicle: int, to: tuple[float, float, float]) -> Array:
    """Return the hover with one vehicle elsewhere for a while."""
    pos = HOVER.copy()
    pos[(since <= T) & (until > T), vehicle] = to
    return pos


def output(flight: Flight, missed: int | None = None) -> str:
    """Return the verdict on a flight in words."""
    verdict = verdict_of(flight, AROUND, missed)
    assert verdict.ok == str(verdict).startswith("ok")
    return str(verdict)
