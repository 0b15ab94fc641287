"""Signals of a flight in arrays: an attribute of a topic's signals in the rows and columns of a grid.

Rows are ticks. A signal belongs to the tick with its stamp; of several with a vehicle, the last counts.
Missing values are NaN.
"""

from collections.abc import Sequence
from itertools import groupby
from operator import attrgetter
from typing import NamedTuple

import numpy as np

from q2q_model.signals.layout import Signal
from q2q_model.signals.rows import stack_equal
from q2q_model.signals.values import Array, Names, Rows, index_of

SAME_TICK = 1e-4
"""Stamps closer than this are the same tick [s]: a hundredth of a tick."""


class TickGrid(NamedTuple):
    """Ticks of the rows and vehicles of the columns."""

    t: Array
    """[s], rising, (T,)."""
    names: Names


class Topic:
    """Signals of a topic, of which each attribute is put into arrays once."""

    def __init__(self, signals: Sequence[Signal]) -> None:
        self.signals = signals
        self.stamps: Array = np.array([one.t for one in signals], dtype=np.float64)
        """[s], (K,)."""
        self.by_names: dict[Names, list[int]] = {}
        """Places of the signals with the same names in the same order."""
        every = list(map(attrgetter("names"), signals))
        for names, run in groupby(range(len(every)), every.__getitem__):
            self.by_names.setdefault(names, []).extend(run)
        self._made: dict[str, dict[Names, Array]] = {}

    def values(self, attribute: str) -> dict[Names, Array]:
        """Return an attribute of all signals with the same names, (k, ...), by these names."""
        if attribute not in self._made:
            every = list(map(attrgetter(attribute), self.signals))
            self._made[attribute] = {
                names: stack_equal(every if len(some) == len(every) else [every[k] for k in some])
                for names, some in self.by_names.items()
            }
        return self._made[attribute]


class _Group(NamedTuple):
    """Where the values of the signals with the same names are in an array of the grid."""

    taken: tuple[Rows, Rows]
    """Signals and vehicles of the group whose value is the last of a tick and vehicle."""
    place: tuple[Rows, Rows]
    """Rows and columns of these values."""


class Table:
    """Signals of a topic in the rows and columns of a grid: the last of each tick and vehicle.

    Several controllers may command a part of the vehicles each, so that a tick has several signals.
    """

    def __init__(self, grid: TickGrid, topic: Topic) -> None:
        self._shape, self._topic = (len(grid.t), len(grid.names)), topic
        self.last = np.asarray(_rows_of_last(grid.t, topic.stamps) >= 0)
        """Which signals are the last of a row, (K,)."""
        newest = _newest(grid, topic)
        self._groups = {names: _group(grid, topic, names, newest) for names in topic.by_names}

    def column(self, attribute: str, width: int) -> Array:
        """Return one attribute, (T, n) or (T, n, width); NaN where missing."""
        made = np.full((*self._shape, width) if width > 1 else self._shape, np.nan)
        for names, values in self._topic.values(attribute).items():
            taken, place = self._groups[names]
            made[place] = values[taken]
        return made


def _newest(grid: TickGrid, topic: Topic) -> Rows:
    """Return the last signal of each tick and vehicle, in the order of recording, (T, n); -1 without one."""
    newest = np.full((len(grid.t), len(grid.names)), -1)
    for names, some in topic.by_names.items():
        row, column = _rows_of_last(grid.t, topic.stamps[some]), index_of(names, grid.names)
        place = np.ix_(row[row >= 0], column[column >= 0])
        newest[place] = np.maximum(newest[place], np.array(some)[row >= 0, None])
    return newest


def _group(grid: TickGrid, topic: Topic, names: Names, newest: Rows) -> _Group:
    """Return where the signals of `names` are; `newest` are the signals that count, (T, n)."""
    some, column = topic.by_names[names], index_of(names, grid.names)
    row = _rows_of_last(grid.t, topic.stamps[some])
    counts = (newest[row[:, None], column] == np.array(some)[:, None]) & (row[:, None] >= 0) & (column >= 0)
    signal, vehicle = np.nonzero(counts)
    return _Group((signal, vehicle), (row[signal], column[vehicle]))


def _rows_of_last(t: Array, stamps: Array) -> Rows:
    """Return the row of each signal that is the last of its row, (K,); -1 for the others."""
    rows = np.clip(np.searchsorted(t, stamps - SAME_TICK), 0, len(t) - 1)
    mine = np.flatnonzero(np.abs(t[rows] - stamps) <= SAME_TICK)
    last, found = np.full(len(t), -1), np.full(len(stamps), -1)
    last[rows[mine]] = mine  # of several, the last stays
    found[last[last >= 0]] = np.flatnonzero(last >= 0)
    return found
