"""What a flight through nodes publishes after an event, and on which topics."""

from dataclasses import dataclass
from typing import NamedTuple

from q2q_model.signals.layout import Signal
from q2q_model.signals.topic_names import TICK_TOPICS
from q2q_sim.simulator.flight_clock import FlightTiming

OUTPUTS = {topic: TICK_TOPICS[topic] for topic in ("mocap", "truth", "truth_interference", "imu")}
"""Published topics and their signals."""


class StampedSignal(NamedTuple):
    """Signal to publish."""

    topic: str
    signal: Signal
    stamp_ns: int


@dataclass(frozen=True, slots=True)
class Output:
    """What to publish after an event."""

    signals: tuple[StampedSignal, ...] = ()
    """In the order of publication."""
    clock_ns: int | None = None
    """Time of a new tick [ns]."""
    timing: FlightTiming | None = None
    """Timing of the flight, once it is over."""
    refusal: str = ""
    """Why a command was refused."""
    gave_up: str = ""
    """Why the vehicles fly on without a command in lockstep, at the first such tick."""


NOTHING = Output()
