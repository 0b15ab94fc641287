"""Faults of a run as a vector of numbers from 0 to 1, in the ranges that campaigns draw from.

Each of SLOTS faults has five numbers:

| number | meaning |
|---|---|
| kind | kind, in equal shares |
| start | start, from the earliest to the last start allowed |
| length | duration, within LENGTHS of the kind |
| size | size, within SIZES of the kind |
| who | vehicle, or pair of vehicles of a swap, in equal shares |
"""

from itertools import combinations
from typing import NamedTuple

import numpy as np

from q2q_model.signals.values import Array, Names
from q2q_sim.campaigns.random_runs.random_run import MOST_FAULTS
from q2q_sim.faults.drawn_faults import LENGTHS, SIZES, earliest_start, kinds_among
from q2q_sim.faults.faults import KINDS, Fault

SLOTS = MOST_FAULTS
"""Faults in a run: as many as campaigns draw at most."""


class FaultNumbers(NamedTuple):
    """Numbers of one fault, 0 to 1 each."""

    kind: float
    start: float
    length: float
    size: float
    who: float


DIMENSION = SLOTS * len(FaultNumbers._fields)
"""Length of a vector."""


def faults_of(vector: Array, names: Names, last_start: float) -> tuple[Fault, ...]:
    """Return the faults of a vector (DIMENSION,), none of which starts after `last_start` [s]."""
    rows = np.asarray(vector).reshape(SLOTS, -1)
    return tuple(_fault(FaultNumbers(*map(float, row)), names, last_start) for row in rows)


def vector_of(faults: tuple[Fault, ...], names: Names, last_start: float) -> Array:
    """Return the vector (DIMENSION,) of SLOTS faults, each number in the middle of its share."""
    return np.concatenate([_numbers(fault, names, last_start) for fault in faults])


def _numbers(fault: Fault, names: Names, last_start: float) -> FaultNumbers:
    kinds, choices = kinds_among(KINDS, names), _choices(fault.kind, names)
    return FaultNumbers(
        kind=(kinds.index(fault.kind) + 0.5) / len(kinds),
        start=fault.start / last_start,
        length=_number(LENGTHS[fault.kind], fault.duration),
        size=_number(SIZES[fault.kind], fault.size) if fault.kind in SIZES else 0.5,
        who=(choices.index(fault.vehicles) + 0.5) / len(choices),
    )


def _fault(numbers: FaultNumbers, names: Names, last_start: float) -> Fault:
    kinds = kinds_among(KINDS, names)
    kind = kinds[_share(numbers.kind, len(kinds))]
    choices = _choices(kind, names)
    return Fault(
        kind=kind,
        start=max(numbers.start * last_start, earliest_start(kind)),
        duration=_between(LENGTHS[kind], numbers.length),
        vehicles=choices[_share(numbers.who, len(choices))],
        size=_between(SIZES[kind], numbers.size) if kind in SIZES else 0.0,
    )


def _choices(kind: str, names: Names) -> list[Names]:
    if KINDS[kind].whole_frame:
        return [()]
    return list(combinations(names, 2)) if kind == "swap" else [(name,) for name in names]


def _share(number: float, count: int) -> int:
    """Return which of `count` equal shares of 0 to 1 a number is in."""
    return min(int(number * count), count - 1)


def _between(bounds: tuple[float, float], number: float) -> float:
    return bounds[0] + number * (bounds[1] - bounds[0])


def _number(bounds: tuple[float, float], value: float) -> float:
    return (value - bounds[0]) / (bounds[1] - bounds[0])
