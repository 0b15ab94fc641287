"""Comparison of recorded flights with their own draws in an air, flight by flight and pooled."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass

import numpy as np

from q2q_model.flights.duplicates.same_flight import is_among
from q2q_model.signals.values import Array, Mask, Names
from q2q_model.vehicle.constants import Vehicle
from q2q_sim.experiments.validation.drawn_air import MakeDraw
from q2q_sim.experiments.validation.error_spectrum import CLEAR_SHARE, EXPOSED_SHARE
from q2q_sim.experiments.validation.error_statistics import (
    Comparison,
    ErrorSums,
    comparison,
    error_sums,
    flight_intervals,
)
from q2q_sim.experiments.validation.flight_alone import ComparedAlone
from q2q_sim.experiments.validation.recorded.recorded_law import RecordedLaw, read_law
from q2q_sim.experiments.validation.recorded.tracked_flight import TrackedFlight
from q2q_sim.experiments.validation.redrawn_flight import Draws, redraw_flight

DRAWS = 20
"""Draws of a flight."""
RMS_RATIO = (0.8, 1.25)
"""Allowed z_rms_ratio: a quarter either way."""
COVERAGE = (0.90, 0.98)
"""Allowed coverage95."""
SPECTRUM_DB = 3.0
"""Largest allowed spectrum_db [dB]: a factor of 2 in power."""


@dataclass(frozen=True, slots=True)
class ValidatedFlight:
    """Recorded flight, its law and its draws."""

    flight: TrackedFlight
    law: RecordedLaw
    drag: float
    """k of rotor_drag [1/s]."""
    drawn: Array
    """z - z_ref of each draw [m], (draws, T, n)."""
    first: Draws
    """The first draw alone."""
    vehicle: Vehicle
    under: tuple[ErrorSums, ...]
    """Rows under a wake, one entry per vehicle."""
    clear: tuple[ErrorSums, ...]
    """Rows in clear air."""

    @property
    def has_wake(self) -> bool:
        """Return whether any row under a wake is compared."""
        return any(part.n for part in self.under)


def validate_flight(
    flight: TrackedFlight, vehicle: Vehicle, make: MakeDraw, seeds: Sequence[int] = range(DRAWS)
) -> ValidatedFlight:
    """Return a flight with its draws, of a vehicle with the lag that it has in the air.

    Raises:
        ValueError: the law cannot be read.
    """
    read = read_law(flight, vehicle)
    draws = redraw_flight(read, vehicle.mass, make, seeds)
    drawn = draws.pos[..., 2] - flight.ref_pos[..., 2]
    under = _sums(flight, drawn, flight.exposed, EXPOSED_SHARE)
    clear = _sums(flight, drawn, flight.free, CLEAR_SHARE)
    return ValidatedFlight(read.flight, read.law, read.drag, drawn, draws.first(), vehicle, under, clear)


def pooled_comparison(flights: Sequence[ValidatedFlight]) -> Comparison:
    """Return the comparison over the rows under a wake of all flights."""
    return comparison([part for one in flights for part in one.under])


def validation_sentence(numbers: Comparison) -> str:
    """Return the verdict on an air in one sentence."""
    if numbers.n == 0:
        return "No row under another vehicle was compared: the air's wakes were not judged."
    misses = [text for ok, text in _judged(numbers) if not ok]
    if not misses:
        return "Under a wake, these recorded flights cannot be told from flights in this air."
    return f"This air is not that of the recorded flights: {'; '.join(misses)}."


def is_told_apart(numbers: Comparison) -> bool:
    """Return whether the recorded flights differ from flights in the air."""
    return not all(ok for ok, _ in _judged(numbers))


def as_json(
    flights: Sequence[ValidatedFlight],
    alone: Sequence[ComparedAlone] = (),
    in_fit: Names = (),
    notes: Sequence[str] = (),
) -> dict[str, object]:
    """Return the numbers of all flights and pooled ones; None where nothing was compared.

    Args:
        flights: flights of several vehicles.
        alone: flights of one vehicle.
        in_fit: names of the flights that the air was learned from, or may have been.
        notes: what is said of the flights.
    """
    return {
        "flights": {
            one.flight.name: {**_flight_json(one), "in_fit": is_among(one.flight.name, in_fit)}
            for one in flights
        },
        "pooled": asdict(pooled_comparison(flights)),
        "pooled_clear": asdict(comparison([part for one in flights for part in one.clear])),
        "intervals": {
            "pooled": flight_intervals([one.under for one in flights]),
            "pooled_clear": flight_intervals([one.clear for one in flights]),
        },
        "alone": {
            "flights": {
                one.name: {**_alone_json([one]), "in_fit": is_among(one.name, in_fit)} for one in alone
            },
            "pooled": _alone_json(alone),
        },
        "notes": list(notes),
        "verdict": validation_sentence(pooled_comparison(flights)),
    }


def _sums(flight: TrackedFlight, drawn: Array, rows: Mask, share: float) -> tuple[ErrorSums, ...]:
    return tuple(
        error_sums(flight.error[:, i], drawn[..., i], rows[:, i] & flight.scored[i], flight.dt, share)
        for i in range(len(flight.names))
    )


def _flight_json(one: ValidatedFlight) -> dict[str, object]:
    law = one.law
    gains = {name: [float(x) for x in np.round(getattr(law, name), 4)] for name in ("k_p", "k_d", "k_i")}
    return {
        **asdict(comparison(one.under)),
        "clear": asdict(comparison(one.clear)),
        "loop": {
            **gains,
            "compensates": law.compensates,
            "attitude_frequency": law.attitude.frequency,
            "residual_mps2": law.rms,
        },
        "drag_per_s": round(one.drag, 4),
    }


def _alone_json(flights: Sequence[ComparedAlone]) -> dict[str, object]:
    lateral = comparison([one.lateral for one in flights])
    return {**asdict(comparison([one.vertical for one in flights])), "lateral": asdict(lateral)}


def _judged(numbers: Comparison) -> list[tuple[bool, str]]:
    """Return whether each target is met, and what is said if not."""
    found = [
        (numbers.z_rms_ratio, RMS_RATIO, "its height errors are {:.2f} times the recorded"),
        (numbers.coverage95, COVERAGE, "its 95 % band holds {:.0%} of the recorded samples"),
        (numbers.spectrum_db, (0.0, SPECTRUM_DB), "its spectrum differs by up to {:.1f} dB"),
    ]
    return [
        (low <= value <= high, text.format(value)) for value, (low, high), text in found if value is not None
    ]
