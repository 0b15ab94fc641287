"""Signals of some of the vehicles of a swarm."""

from dataclasses import replace
from typing import TypeVar

from q2q_model.signals.layout import LAYOUTS, Signal
from q2q_model.signals.values import Rows

S = TypeVar("S", bound=Signal)


def of_vehicles(signal: S, rows: Rows) -> S:
    """Return the signal of the vehicles in `rows`, in that order."""
    names = tuple(signal.names[row] for row in rows)
    parts = {
        column.attribute: getattr(signal, column.attribute)[rows] for column in LAYOUTS[type(signal)].columns
    }
    return replace(signal, names=names, **parts)
