"""Line up the signals of one tick by vehicle name, and say which vehicles can be flown on them.

A vehicle is usable when its state and its setpoint are there, finite, of a size that a room can hold, and
not LOST. Unusable rows are filled with a hover at rest, so that the laws run over all rows alike; their
answer is never sent (q2q_control.row_memory).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from q2q_model.signals import (
    Array,
    Interference,
    Names,
    SwarmSetpoint,
    SwarmState,
    TrackStatus,
    index_of,
)

ABSURD = 1e4
"""No position, velocity, acceleration or angle of a room is this large [SI]."""
QUAT_SLACK = 0.1
"""How far the squared length of a usable quaternion may be from 1 [-]."""

POS, VEL, QUAT = slice(0, 3), slice(3, 6), slice(6, 10)
REF_POS, REF_VEL, REF_ACC = slice(10, 13), slice(13, 16), slice(16, 19)
YAW, YAW_RATE, ETA = 19, 20, slice(21, 24)
_WIDTH = 24
_LOST = int(TrackStatus.LOST)
_HOVER = np.zeros(_WIDTH)
_HOVER[9] = 1.0  # level: the quaternion's w


@dataclass(frozen=True, slots=True)
class Aligned:
    """Hold one tick's numbers, one row a vehicle in the order of `names`."""

    t: float
    names: Names
    usable: NDArray[np.bool_]
    """(n,)"""
    table: Array
    """Columns POS, VEL, QUAT of the state, REF_POS, REF_VEL, REF_ACC, YAW, YAW_RATE of the setpoint, and
    the draft's acceleration ETA (0 where none is predicted): units and frames of the signals, (n, 24)."""


def align(
    state: SwarmState, setpoint: SwarmSetpoint, interference: Interference | None, vehicles: Names = ()
) -> Aligned:
    """Return the tick of the vehicles of `setpoint`, or of `vehicles` where given.

    Vehicles that are absent from a signal get unusable rows; a draft that is absent or not finite is 0.
    """
    names = vehicles or setpoint.names
    table = np.zeros((len(names), _WIDTH))
    _fill(table, _rows(state.names, names), (POS, state.pos), (VEL, state.vel), (QUAT, state.quat))
    plan = _rows(setpoint.names, names)
    _fill(table, plan, (REF_POS, setpoint.pos), (REF_VEL, setpoint.vel), (REF_ACC, setpoint.acc))
    _fill(table, plan, (YAW, setpoint.yaw), (YAW_RATE, setpoint.yaw_rate))
    usable = _sound(table, _lost(state, names))
    if interference is not None:
        _fill(table, _rows(interference.names, names), (ETA, interference.acc))
        eta = table[:, ETA]
        if not np.abs(eta).max(initial=0.0) < ABSURD:  # NaN too
            eta[~(np.abs(eta) < ABSURD)] = 0.0
    if not usable.all():
        table[~usable] = _HOVER
    return Aligned(setpoint.t, names, usable, table)


def _rows(have: Names, want: Names) -> NDArray[np.intp] | None:
    """Return the row in `have` of each of `want`, -1 where absent; None where they are the same."""
    return None if have == want else index_of(want, have)


def _fill(table: Array, rows: NDArray[np.intp] | None, *columns: tuple[slice | int, Array]) -> None:
    for where, part in columns:
        if rows is None:
            table[:, where] = part
            continue
        table[:, where] = np.nan
        table[rows >= 0, where] = part[rows[rows >= 0]]


def _lost(state: SwarmState, names: Names) -> NDArray[np.bool_]:
    lost = state.status == _LOST
    rows = _rows(state.names, names)
    return lost if rows is None else np.append(lost, True)[rows]


def _sound(table: Array, lost: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return which rows can be flown on, (n,); rows that are not numbers become 0."""
    whole = (np.abs(table) < ABSURD).all(axis=1)  # False for NaN
    if not whole.all():
        table[~whole] = 0.0
    quat = table[:, QUAT]
    length = (quat * quat).sum(axis=1)
    return np.asarray(whole & (np.abs(length - 1.0) < QUAT_SLACK) & ~lost)
