"""Warm-up: synthetic ticks that load all code of a block before its first real tick."""

from collections.abc import Callable, Iterable

import numpy as np

from q2q_model.signals.layout import LAYOUTS, Column, Signal
from q2q_model.signals.values import Array, MocapFrame, Names, Status, SwarmState, TrackStatus

SPACING = 0.5
"""Vertical distance between the vehicles [m], small enough for downwash."""
LAYERS = 4
"""Vehicles per vertical stack; stacks stand side by side within the room."""
DRIFT = 0.01
"""Speed [m/s]: a pose repeated bit for bit counts as an old frame."""
STAND_IN = ("cf1", "cf2")
TICKS = ((0.0, False), (0.01, False), (0.02, False), (0.03, True), (0.04, False))
"""Time [s] and whether a vehicle is missing: a track starts, is confirmed, followed, and coasts."""
LOST_S = 0.5
"""Age of the lost vehicle [s]."""


def warm_up(
    update: Callable[..., object], reset: Callable[[], None], kinds: Iterable[type], names: Names = ()
) -> None:
    """Run a block on synthetic ticks, then reset it, so that neither the first tick nor a dropout is slow."""
    signal_types = tuple(kinds)
    for t, unseen in TICKS:
        update(*(synthetic_signal(kind, t, names, unseen=unseen) for kind in signal_types))
    reset()


def synthetic_signal(kind: type, t: float, names: Names = (), *, unseen: bool = False) -> Signal:
    """Return a plausible signal of this type at time t [s]: vehicles in stacks that drift slowly.

    With `unseen`, the first vehicle is missing from a MocapFrame and lost in a SwarmState.
    """
    vehicles = names or STAND_IN
    arrays = {column.attribute: _values(column, len(vehicles)) for column in LAYOUTS[kind].columns}
    if "pos" in arrays:
        arrays["pos"][:, 0] += DRIFT * (t % 1.0)
    if unseen and kind is MocapFrame:
        arrays["pos"][0] = arrays["quat"][0] = np.nan
    if unseen and kind is SwarmState:
        arrays["status"][0], arrays["age"][0] = TrackStatus.LOST, LOST_S
    made: Signal = kind(t=t, names=vehicles, **arrays)
    return made


def _values(column: Column, vehicles: int) -> Array | Status:
    if column.attribute == "status":
        return np.zeros(vehicles, dtype=np.uint8)
    shape = (vehicles,) if column.width == 1 else (vehicles, column.width)
    values = np.zeros(shape)
    if column.attribute == "pos":
        stack, layer = np.divmod(np.arange(vehicles), LAYERS)
        values[:, 0], values[:, 2] = 0.2 * SPACING * stack, SPACING * (1 + layer)
    if column.attribute == "quat":
        values[:, 3] = 1.0
    return values
