"""Make signals to rehearse a block with before its first tick, so that its code is loaded by then."""

import numpy as np

from q2q_model.layout import LAYOUTS, Column, Signal
from q2q_model.signals import Array, Names, Status

SPACING = 0.5
"""Height between the rehearsal's vehicles [m]: near enough that a model sees a draft."""
STAND_IN = ("cf1", "cf2")


def rehearsal(kind: type, t: float, names: Names = ()) -> Signal:
    """Return a plausible signal of this kind: vehicles at rest above each other, at time t [s]."""
    who = names or STAND_IN
    arrays = {column.attribute: _values(column, len(who)) for column in LAYOUTS[kind].columns}
    made: Signal = kind(t=t, names=who, **arrays)
    return made


def _values(column: Column, vehicles: int) -> Array | Status:
    if column.attribute == "status":
        return np.zeros(vehicles, dtype=np.uint8)
    shape = (vehicles,) if column.width == 1 else (vehicles, column.width)
    values = np.zeros(shape)
    if column.attribute == "pos":
        values[:, 2] = SPACING * np.arange(1, vehicles + 1)
    if column.attribute == "quat":
        values[:, 3] = 1.0
    return values
