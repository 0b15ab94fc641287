"""Numbers of the vehicles of a flight: a row for each, or a summary of many."""

import math
from collections.abc import Callable, Mapping, Sequence
from statistics import median

MOST_ROWS = 10
"""Most vehicles with a row of their own."""
MOST_DRAWN = 4
"""Vehicles that are drawn where there are more than that."""


def vehicle_rows(numbers: Mapping[str, Sequence[float]]) -> list[tuple[str, list[float]]]:
    """Return name and numbers of each vehicle; of more than MOST_ROWS, median and extremes of each number.

    A number that is unknown (NaN) for some vehicles is summarised over the others, whose count is below it.
    """
    if len(numbers) <= MOST_ROWS:
        return [(name, list(row)) for name, row in numbers.items()]
    columns = [_finite(column) for column in zip(*numbers.values(), strict=True)]
    ways: dict[str, Callable[[list[float]], float]] = {"median": median, "smallest": min, "largest": max}
    return [
        *((way, [of(column) if column else math.nan for column in columns]) for way, of in ways.items()),
        ("vehicles", [len(column) for column in columns]),
    ]


def plotted_vehicles(errors: Mapping[str, float]) -> list[str]:
    """Return the vehicles to draw: all, or beyond MOST_ROWS the MOST_DRAWN of the largest errors."""
    if len(errors) <= MOST_ROWS:
        return list(errors)
    return sorted(errors, key=lambda name: math.inf if math.isnan(errors[name]) else -errors[name])[
        :MOST_DRAWN
    ]


def drawn_vehicles_note(count: int, flight: str) -> list[str]:
    """Return which of so many vehicles `plotted_vehicles` chose by their z RMSE; nothing if all."""
    if count <= MOST_ROWS:
        return []
    return [f"Drawn are the {MOST_DRAWN} of {count} vehicles with the largest z RMSE in flight {flight}."]


def _finite(column: Sequence[float]) -> list[float]:
    return [value for value in column if math.isfinite(value)]
