"""Line up the signals of one tick by vehicle name, and say which vehicles can be flown on them.

A vehicle is usable when its state and its setpoint are there, finite, of a size that a room can hold, and
not LOST. Unusable rows are filled with a hover at rest, so that the laws run over all rows alike; their
answer is never sent (q2q_control.failsafe.last_commands).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from q2q_model.compiled import compiled
from q2q_model.signals.values import (
    Array,
    Interference,
    Names,
    Status,
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
TRACK = 24
_WIDTH = 25
_LOST = int(TrackStatus.LOST)
_QUAT_AT, _ETA_AT = 6, 21


@dataclass(frozen=True, slots=True)
class Aligned:
    """Arrays of one tick, one row a vehicle in the order of `names`."""

    t: float
    names: Names
    usable: NDArray[np.bool_]
    """(n,)"""
    table: Array
    """Columns POS, VEL, QUAT of the state, REF_POS, REF_VEL, REF_ACC, YAW, YAW_RATE of the setpoint, the
    downwash's acceleration ETA (0 where none is predicted), and the state's TRACK status: units and frames of
    the signals, (n, 25)."""


def align(
    state: SwarmState, setpoint: SwarmSetpoint, interference: Interference | None, vehicles: Names = ()
) -> Aligned:
    """Return the tick of the vehicles of `setpoint`, or of `vehicles` where given.

    Vehicles that are absent from a signal get unusable rows; downwash that is absent or not finite is 0.
    """
    names = vehicles or setpoint.names
    table, usable = np.empty((len(names), _WIDTH)), np.empty(len(names), dtype=np.bool_)
    parts = _columns(state, setpoint, interference, len(names))
    same = interference is None or interference.names == names
    if same and state.names == names and setpoint.names == names:
        np.concatenate([part for _, columns in parts for part in columns], axis=1, out=table)
    else:
        at = 0
        for have, columns in parts:
            rows = index_of(names, names if have is None else have)
            for part in columns:
                table[:, at : at + part.shape[1]] = np.nan
                table[rows >= 0, at : at + part.shape[1]] = part[rows[rows >= 0]]
                at += part.shape[1]
    sort_out(table, usable)
    return Aligned(setpoint.t, names, usable, table)


def _columns(
    state: SwarmState, setpoint: SwarmSetpoint, interference: Interference | None, vehicles: int
) -> tuple[tuple[Names | None, tuple[Array | Status, ...]], ...]:
    """Return the columns of a table, in order, with the names of their rows; None are the table's own."""
    yaw, yaw_rate = setpoint.yaw[:, None], setpoint.yaw_rate[:, None]
    plan = setpoint.pos, setpoint.vel, setpoint.acc, yaw, yaw_rate
    downwash = (
        (None, (np.zeros((vehicles, 3)),))
        if interference is None
        else (interference.names, (interference.acc,))
    )
    return (
        (state.names, (state.pos, state.vel, state.quat)),
        (setpoint.names, plan),
        downwash,
        (state.names, (state.status[:, None],)),
    )


@compiled
def sort_out(table: Array, usable: NDArray[np.bool_]) -> None:
    """Write which rows of a table can be flown on into `usable` (n,); the others become a hover at rest."""
    for i in range(table.shape[0]):
        row = table[i]
        whole, length = row[TRACK] != _LOST, 0.0
        for k in range(_ETA_AT):
            whole = whole and abs(row[k]) < ABSURD  # False for NaN
        for k in range(_QUAT_AT, _QUAT_AT + 4):
            length += row[k] * row[k]
        usable[i] = whole and abs(length - 1.0) < QUAT_SLACK
        if not usable[i]:
            row[:] = 0.0
            row[_QUAT_AT + 3] = 1.0  # level: the quaternion's w
        for k in range(_ETA_AT, _ETA_AT + 3):
            if not abs(row[k]) < ABSURD:
                row[k] = 0.0
