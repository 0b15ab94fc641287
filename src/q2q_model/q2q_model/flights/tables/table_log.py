"""Columns of a flight table that no signal contains, as a log."""

import numpy as np

from q2q_model.flights.flight_log import FlightLog
from q2q_model.flights.tables.flight_table import (
    ACC,
    ANGLES,
    EULER,
    POS,
    QUAT,
    RATE,
    REF,
    REF_VEL,
    THRUST,
    VEL,
    YAW_REF,
    FlightTable,
    attitude,
    has_attitude,
)

UNITS = {
    **dict.fromkeys(REF, "m"),
    **dict.fromkeys((*VEL, *REF_VEL), "m/s"),
    **dict.fromkeys(ACC, "m/s^2"),
    **dict.fromkeys(EULER, "rad"),
    **dict.fromkeys(RATE, "rad/s"),
    **dict.fromkeys(YAW_REF, "deg"),
    "vbat": "V",
    "fa_ff": "N",
    "thrust_est": "N",
    "faz_est": "N",
    "est_x": "m",
    "est_y": "m",
    "est_z": "m",
}


def log_of(table: FlightTable) -> FlightLog:
    """Return the columns that no signal contains."""
    carried = _carried(table)
    rest = tuple(name for name in table.columns if name not in carried)
    shape = (len(table.t), len(table.names), 0)
    values = table.vectors(rest) if rest else np.zeros(shape)
    return FlightLog(table.t, table.names, rest, tuple(UNITS.get(name, "") for name in rest), values)


def _carried(table: FlightTable) -> set[str]:
    """Return the columns that signals of this table contain for all vehicles that have them.

    Plain angles repeat an attitude next to them. A state holds a velocity without an attitude.
    """
    groups = [POS, QUAT, EULER, THRUST]
    moving = [group for group in (VEL, ACC) if table.has(group)] if has_attitude(table) else []
    groups += [group for group in (ANGLES, *moving) if group == VEL or _all_turned(table, group)]
    groups += [RATE] if moving else []
    groups += [REF, REF_VEL, YAW_REF] if table.has(REF) else []
    return {name for group in groups if table.has(group) for name in group}


def _all_turned(table: FlightTable, group: tuple[str, ...]) -> bool:
    """Return whether every vehicle with values of a group has an attitude."""
    if not table.has(group):
        return False
    known = np.isfinite(table.vectors(group)).any(axis=(0, 2))  # (n,)
    return not (known & ~np.isfinite(attitude(table)).all(axis=2).any(axis=0)).any()
