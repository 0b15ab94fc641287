"""Signals of one tick aligned by vehicle name, and which of the vehicles are usable.

A vehicle is seen if its position and velocity are present, finite, of plausible size, and it is not LOST;
usable if its attitude and its setpoint are, too. Unusable rows are filled, so that the laws run over all rows
alike: with a setpoint at rest where the vehicle is seen, level if it has no attitude, or with a hover at rest
at the origin. Their commands are never sent (q2q_control.failsafe.last_commands).
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from q2q_model.compiled import compiled
from q2q_model.signals.values import (
    KNOWN_NAMES,
    LOST,
    Array,
    Interference,
    Names,
    Status,
    SwarmSetpoint,
    SwarmState,
    index_of,
)

LARGEST_VALUE = 1e4
"""Bound on plausible positions, velocities, accelerations and angles [SI]."""
QUAT_SLACK = 0.1
"""Largest difference of a usable quaternion's squared length from 1 [-]."""

POS_AT, VEL_AT, QUAT_AT = 0, 3, 6
REF_POS_AT, REF_VEL_AT, REF_ACC_AT = 10, 13, 16
YAW, YAW_RATE, ETA_AT, TRACK = 19, 20, 21, 24
"""Columns of a table, the first one of vectors: for compiled code."""
POS, VEL, QUAT = slice(POS_AT, POS_AT + 3), slice(VEL_AT, VEL_AT + 3), slice(QUAT_AT, QUAT_AT + 4)
REF_POS, REF_VEL = slice(REF_POS_AT, REF_POS_AT + 3), slice(REF_VEL_AT, REF_VEL_AT + 3)
REF_ACC, ETA = slice(REF_ACC_AT, REF_ACC_AT + 3), slice(ETA_AT, ETA_AT + 3)
_WIDTH = 25


@dataclass(frozen=True, slots=True)
class Aligned:
    """Arrays of one tick, one row per vehicle in the order of `names`."""

    t: float
    names: Names
    usable: NDArray[np.bool_]
    """(n,)"""
    seen: NDArray[np.bool_]
    """(n,)"""
    all_usable: bool
    table: Array
    """Columns POS, VEL, QUAT of the state, REF_POS, REF_VEL, REF_ACC, YAW, YAW_RATE of the setpoint, the
    downwash's acceleration ETA (0 where none is predicted), and the state's TRACK status, in the units and
    frames of the signals, (n, 25)."""

    @property
    def stray(self) -> NDArray[np.bool_]:
        """Return which vehicles are seen but have no usable attitude or setpoint, (n,)."""
        return self.seen & ~self.usable


def align(
    state: SwarmState, setpoint: SwarmSetpoint, interference: Interference | None, vehicles: Names = ()
) -> Aligned:
    """Return the aligned signals of the vehicles of `setpoint`, or of `vehicles` if given.

    Vehicles missing from a signal get unusable rows; downwash that is missing or not finite is 0.
    """
    names = vehicles or setpoint.names
    n = len(names)
    table, usable, seen = np.empty((n, _WIDTH)), np.empty(n, np.bool_), np.empty(n, np.bool_)
    moving = (state.pos, state.vel, state.quat, state.status[:, None])
    plan = (setpoint.pos, setpoint.vel, setpoint.acc, setpoint.yaw[:, None], setpoint.yaw_rate[:, None])
    *motion, track = _picked(moving, state.names, names)
    asked = _picked(plan, setpoint.names, names)
    eta: tuple[Array | Status, ...] = (np.zeros((n, 3)),)
    if interference is not None:
        eta = _picked((interference.acc,), interference.names, names)
    np.concatenate((*motion, *asked, *eta, track), axis=1, out=table)
    return Aligned(setpoint.t, names, usable, seen, mark_usable(table, usable, seen), table)


def _picked(columns: tuple[Array | Status, ...], have: Names, names: Names) -> tuple[Array | Status, ...]:
    """Return the rows of `names` of columns whose rows are `have`; NaN where missing."""
    if have == names:
        return columns
    rows, whole = _rows_of(names, have)
    if whole:
        return tuple(column[rows] for column in columns)
    known = (rows >= 0)[:, None]
    missing = (np.concatenate([column, np.full((1, column.shape[1]), np.nan)]) for column in columns)
    return tuple(np.where(known, column[rows], np.nan) for column in missing)


@lru_cache(maxsize=KNOWN_NAMES)
def _rows_of(names: Names, have: Names) -> tuple[NDArray[np.intp], bool]:
    """Return the row in `have` of each of `names`, -1 where it is missing, and whether none is."""
    rows = index_of(names, have)
    return rows, bool((rows >= 0).all())


@compiled
def mark_usable(table: Array, usable: NDArray[np.bool_], seen: NDArray[np.bool_]) -> bool:
    """Write which rows of a table are usable and which are seen, (n,) each, and fill the unusable ones.

    Returns:
        Whether all are usable.
    """
    every = True
    for i in range(table.shape[0]):
        row = table[i]
        seen[i] = row[TRACK] != LOST and _is_plausible(row[:QUAT_AT])
        turned = _is_unit(row)
        usable[i] = seen[i] and turned and _is_plausible(row[REF_POS_AT:ETA_AT])
        if not usable[i]:
            every = False
        if not seen[i]:
            row[:] = 0.0
        elif not usable[i]:
            row[REF_POS_AT:REF_VEL_AT], row[REF_VEL_AT:ETA_AT] = row[POS_AT:VEL_AT], 0.0
        if not (seen[i] and turned):
            row[QUAT_AT : QUAT_AT + 3], row[QUAT_AT + 3] = 0.0, 1.0  # level
        for k in range(ETA_AT, ETA_AT + 3):
            if not abs(row[k]) < LARGEST_VALUE:
                row[k] = 0.0
    return every


@compiled
def _is_plausible(values: Array) -> bool:
    """Return whether all values (k,) are finite and of plausible size."""
    plausible = True
    for value in values:
        plausible = plausible and abs(value) < LARGEST_VALUE  # False for NaN
    return plausible


@compiled
def _is_unit(row: Array) -> bool:
    """Return whether the quaternion of a row has unit length; not if it is not finite."""
    length = 0.0
    for k in range(QUAT_AT, QUAT_AT + 4):
        length += row[k] * row[k]
    return abs(length - 1.0) < QUAT_SLACK
