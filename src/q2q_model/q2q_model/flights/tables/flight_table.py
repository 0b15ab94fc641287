"""A table of a real flight: its columns by vehicle, checked, in SI units with one row per tick.

| layout | columns | vehicles |
|---|---|---|
| several | `t`, then `<name>_x`, `<name>_y`, ... for each vehicle | q2q_model.flights.tables.table_vehicles |
| one | `t`, then `x`, `y`, ... | `cf1` |

Angles are Z-Y-X, pitch nose down, and count where no quaternion is. table_signals has what columns become.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from q2q_model.counted import counted
from q2q_model.flights.tables.table_vehicles import AXES, vehicle_prefixes
from q2q_model.flights.units_and_frames.unit_check import check_metres
from q2q_model.flights.units_and_frames.velocity_check import check_velocities
from q2q_model.geometry.rotations import normalised, quat_from_euler
from q2q_model.signals.stamps import END_S
from q2q_model.signals.values import Array, Mask, Names

POS, QUAT, VEL, RATE = AXES, ("qx", "qy", "qz", "qw"), ("vx", "vy", "vz"), ("wp", "wq", "wr")
EULER, ANGLES = ("roll_rad", "pitch_rad", "yaw_rad"), ("roll", "pitch", "yaw")
YAW_REF, THRUST = ("yawref_deg",), ("thrust_cmd",)
REF, REF_VEL, ACC = ("xref", "yref", "zref"), ("vxref", "vyref", "vzref"), ("ax", "ay", "az")
CARRIED = {*POS, *QUAT, *EULER, *ANGLES, *VEL, *RATE, *REF, *REF_VEL, *YAW_REF, *ACC, *THRUST}
"""Columns that signals contain, with those they need."""
LONGEST_STEP = 0.5
"""Longest median time between rows of a flight [s]; steps of 30 Hz in milliseconds are 33."""


@dataclass(frozen=True, slots=True)
class FlightTable:
    """Validated columns of a table."""

    t: Array
    """[s], rising, (T,)."""
    names: Names
    columns: Mapping[str, Array]
    """Column name without vehicle -> values, (T, n); NaN where a vehicle lacks it."""

    def has(self, names: tuple[str, ...]) -> bool:
        """Return whether all these columns exist."""
        return all(name in self.columns for name in names)

    def vectors(self, names: tuple[str, ...]) -> Array:
        """Return columns side by side, (T, n, len(names))."""
        return np.stack([self.columns[name] for name in names], axis=-1)

    @property
    def gap(self) -> Mask:
        """Return the rows that are interpolated, (T, n)."""
        if "gap" in self.columns:
            return np.asarray(self.columns["gap"] > 0.0)
        return np.zeros((len(self.t), len(self.names)), dtype=bool)


def flight_table(columns: Mapping[str, Array]) -> FlightTable:
    """Return a table's columns, (T,) each, sorted by vehicle; without those of signals that are empty.

    Raises ValueError for a table without t or positions or with fewer than two rows, one whose columns can be
    read as those of one vehicle or of several, a time that is negative, not a number or not increasing, or
    times, positions, velocities and angles that are not in s, m, m/s and rad.
    """
    if "t" not in columns:
        raise ValueError(f"the table has no column t [s]; it has {', '.join(columns)}")
    t = np.asarray(columns["t"], dtype=np.float64)
    if len(t) < 2:
        raise ValueError(f"the table has {counted(len(t), 'row')}; must be at least 2")
    late = np.flatnonzero(~(np.diff(t) > 0.0))
    if not t[0] >= 0.0 or len(late):
        row = int(late[0]) + 1 if len(late) else 0
        raise ValueError(f"t must begin at 0 or later and increase; row {row} of {len(t)} does not")
    prefixes = vehicle_prefixes(tuple(columns), CARRIED)
    names = tuple(prefixes)
    found: dict[str, Array] = {}
    for row, key in enumerate(prefixes.values()):
        for name in columns:
            if name != "t" and name.startswith(key):
                place = found.setdefault(name.removeprefix(key), np.full((len(t), len(names)), np.nan))
                place[:, row] = columns[name]
    table = FlightTable(t, names, {name: one for name, one in found.items() if _is_logged(name, one)})
    _check_units(table)
    return table


def _is_logged(name: str, column: Array) -> bool:
    """Return whether a column has a number, or is one that needs none: a position, or no signal's."""
    return name in POS or name not in CARRIED or bool(np.isfinite(column).any())


def _check_units(table: FlightTable) -> None:
    """Raise ValueError for quantities that are not in s, m, m/s or rad, or times that no stamp can hold."""
    step = float(np.median(np.diff(table.t)))
    if step > LONGEST_STEP:
        raise ValueError(f"t steps by {step:g} s (maximum {LONGEST_STEP:g} s): check that it is in seconds")
    if not table.t[-1] < END_S:
        raise ValueError(
            f"t ends at {table.t[-1]:.10g} s, but stamps must be below {END_S} s (32 bits): subtract the "
            "first t from all"
        )
    check_metres(table.names, table.vectors(POS))
    if table.has(VEL):
        check_velocities(table.t, table.names, table.vectors(POS), table.vectors(VEL))
    if table.has(REF):
        check_metres(tuple(f"the reference of {name}" for name in table.names), table.vectors(REF))
    if table.has(EULER):
        _check_radians(table)


def _check_radians(table: FlightTable) -> None:
    """Raise ValueError if angles that are the attitude of a vehicle are not in radians."""
    used = ~has_quat(table)
    for k, name in enumerate(table.names):
        tilt = float(np.nanmax(np.abs(table.vectors(EULER[:2])[used[:, k], k]), initial=0.0))
        if tilt > np.pi:
            raise ValueError(
                f"roll_rad and pitch_rad of {name} reach {tilt:g}; must be in radians: a column map "
                "(bag_import --columns) scales degrees by 0.0174533"
            )


def has_attitude(table: FlightTable) -> bool:
    """Return whether the table has an attitude, as quaternions or angles."""
    return table.has(QUAT) or table.has(EULER)


def attitude(table: FlightTable) -> Array:
    """Return the attitude as quaternions x y z w, (T, n, 4): of angles where there is none; else NaN."""
    quat = np.full((len(table.t), len(table.names), 4), np.nan)
    if table.has(EULER):
        quat = quat_from_euler(*(table.columns[name] for name in EULER))
    if table.has(QUAT):
        quat = np.where(has_quat(table)[..., None], normalised(table.vectors(QUAT)), quat)
    return quat


def has_quat(table: FlightTable) -> Mask:
    """Return the rows with a quaternion, (T, n)."""
    if not table.has(QUAT):
        return np.zeros((len(table.t), len(table.names)), dtype=bool)
    return np.asarray(np.isfinite(normalised(table.vectors(QUAT))).all(axis=-1))
