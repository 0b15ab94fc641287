"""Signals of some of the vehicles of a swarm."""

from dataclasses import replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from q2q_model.signals.layout import LAYOUTS, Signal

S = TypeVar("S", bound=Signal)


def of_vehicles(signal: S, rows: NDArray[np.intp]) -> S:
    """Return the signal of the vehicles in `rows`, in that order."""
    names = tuple(signal.names[row] for row in rows)
    parts = {
        column.attribute: getattr(signal, column.attribute)[rows] for column in LAYOUTS[type(signal)].columns
    }
    return replace(signal, names=names, **parts)
