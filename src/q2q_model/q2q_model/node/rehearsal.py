"""Make signals to rehearse a block with before its first tick, so that its code is loaded by then."""

from collections.abc import Callable, Iterable

import numpy as np

from q2q_model.signals.layout import LAYOUTS, Column, Signal
from q2q_model.signals.values import Array, MocapFrame, Names, Status, SwarmState, TrackStatus

SPACING = 0.5
"""Height between the rehearsal's vehicles [m]: near enough that a model sees downwash."""
STOREYS = 4
"""So many vehicles stand above each other, the next beside them: all are within a room."""
DRIFT = 0.01
"""Speed [m/s]: a pose that is the last one again to the last digit is an old one."""
STAND_IN = ("cf1", "cf2")
TICKS = ((0.0, False), (0.01, False), (0.02, False), (0.03, True), (0.04, False))
"""When [s], and whether a vehicle is not seen: a track is begun, believed, followed, and bridged."""
LOST_S = 0.5
"""How long the lost vehicle has not been seen [s]."""


def rehearse(
    update: Callable[..., object], reset: Callable[[], None], kinds: Iterable[type], names: Names = ()
) -> None:
    """Run a block on made-up ticks and reset it: the first real one, and first absence, are not slow."""
    wanted = tuple(kinds)
    for t, unseen in TICKS:
        update(*(rehearsal(kind, t, names, unseen=unseen) for kind in wanted))
    reset()


def rehearsal(kind: type, t: float, names: Names = (), *, unseen: bool = False) -> Signal:
    """Return a plausible signal of this kind: vehicles above each other that drift, at time t [s].

    With `unseen`, the first one is missing where poses are measured, and lost where they are estimated.
    """
    who = names or STAND_IN
    arrays = {column.attribute: _values(column, len(who)) for column in LAYOUTS[kind].columns}
    if "pos" in arrays:
        arrays["pos"][:, 0] += DRIFT * (t % 1.0)
    if unseen and kind is MocapFrame:
        arrays["pos"][0] = arrays["quat"][0] = np.nan
    if unseen and kind is SwarmState:
        arrays["status"][0], arrays["age"][0] = TrackStatus.LOST, LOST_S
    made: Signal = kind(t=t, names=who, **arrays)
    return made


def _values(column: Column, vehicles: int) -> Array | Status:
    if column.attribute == "status":
        return np.zeros(vehicles, dtype=np.uint8)
    shape = (vehicles,) if column.width == 1 else (vehicles, column.width)
    values = np.zeros(shape)
    if column.attribute == "pos":
        stack, storey = np.divmod(np.arange(vehicles), STOREYS)
        values[:, 0], values[:, 2] = 0.2 * SPACING * stack, SPACING * (1 + storey)
    if column.attribute == "quat":
        values[:, 3] = 1.0
    return values
