"""Whether flights, one by one, were flown with the same gains.

Two flights differ in a gain if its intervals do not overlap and its values differ by more than `APART`;
those of recorded flights of one controller differ by up to 8 %, more than their intervals allow.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

from q2q_model.identification.gains.altitude_record import AltitudeRecord
from q2q_model.identification.gains.command_gains import gains_from_commands
from q2q_model.identification.statistics.intervals import Interval

APART = 0.2
"""Difference of two gains over the larger one from which they are those of two controllers [-]."""


@dataclass(frozen=True, slots=True)
class FlightGain:
    """One gain of one flight."""

    flight: str
    symbol: str
    gain: Interval


def differing_gains(records: Sequence[AltitudeRecord]) -> tuple[FlightGain, FlightGain] | None:
    """Return the smaller and the larger gain of two flights that differ; None if no two do.

    Flights with too few commands for gains of their own are left out.
    """
    each = _gains_by_flight(records)
    for symbol in ("K_p", "K_d"):
        own = [one for one in each if one.symbol == symbol]
        rising = sorted(own, key=lambda one: one.gain.high)
        falling = sorted(own, key=lambda one: one.gain.low, reverse=True)
        for pair in product(rising, falling):  # the pair furthest apart first
            if _differ(pair[0].gain, pair[1].gain):
                return pair
    return None


def _differ(less: Interval, more: Interval) -> bool:
    larger = max(abs(more.value), abs(less.value))
    return less.high < more.low and more.value - less.value > APART * larger


def _gains_by_flight(records: Sequence[AltitudeRecord]) -> list[FlightGain]:
    found = []
    for name in dict.fromkeys(record.name for record in records):
        try:
            fit = gains_from_commands([record for record in records if record.name == name])
        except ValueError:  # too few commands
            continue
        found += [FlightGain(name, "K_p", fit.k_p), FlightGain(name, "K_d", fit.k_d)]
    return found
