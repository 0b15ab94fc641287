"""Conversion of a table of a real flight into signals.

Two layouts are supported, both in SI units with one row per tick:

| layout | columns | vehicles |
|---|---|---|
| several | `t`, then `<name>_x`, `<name>_y`, ... for each vehicle | q2q_model.flights.tables.table_vehicles |
| one | `t`, then `x`, `y`, ... | `cf1` |

| columns | become |
|---|---|
| x y z, qx qy qz qw or roll_rad pitch_rad yaw_rad | mocap; not where `gap` is set: it is interpolated |
| vx vy vz (with the above), wp wq wr | state, as estimated onboard; COASTING in a gap |
| xref yref zref, vxref vyref vzref, yawref_deg | reference; acceleration by differences, unless held |
| thrust_cmd | command; roll, pitch and yaw rate are not logged: NaN |
| ax ay az (with an attitude), wp wq wr | imu: R(q)^T (a + g e_z), because az excludes gravity |
| all others, and those of a row above in part | the log, under their own names |

Angles are Z-Y-X, pitch nose down, and count where no quaternion is. Plain roll pitch yaw, which
may be degrees, are no attitude; next to one they repeat it. Rates that are absent are NaN.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from q2q_model.flights.flight_log import FlightLog
from q2q_model.flights.sampled_reference import is_rare
from q2q_model.flights.tables.table_vehicles import vehicle_prefixes
from q2q_model.flights.unit_check import check_metres
from q2q_model.geometry.rotations import normalised, quat_from_euler, rotate_inverse
from q2q_model.signals.layout import Signal
from q2q_model.signals.stamps import stamp_from_time, time_from_stamp
from q2q_model.signals.values import (
    Array,
    Mask,
    MocapFrame,
    Names,
    SwarmCommand,
    SwarmImu,
    SwarmSetpoint,
    SwarmState,
    TrackStatus,
)
from q2q_model.vehicle.constants import GRAVITY

POS, QUAT, VEL, RATE = ("x", "y", "z"), ("qx", "qy", "qz", "qw"), ("vx", "vy", "vz"), ("wp", "wq", "wr")
REF, REF_VEL, ACC = ("xref", "yref", "zref"), ("vxref", "vyref", "vzref"), ("ax", "ay", "az")
EULER, ANGLES = ("roll_rad", "pitch_rad", "yaw_rad"), ("roll", "pitch", "yaw")
YAW_REF, THRUST = ("yawref_deg",), ("thrust_cmd",)
CARRIED = {*POS, *QUAT, *EULER, *ANGLES, *VEL, *RATE, *REF, *REF_VEL, *YAW_REF, *ACC, *THRUST}
"""Columns that signals contain, with those they need."""
LONGEST_STEP = 0.5
"""Longest median time between rows of a flight [s]; steps of 30 Hz in milliseconds are 33."""
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
    """Return a table's columns sorted by vehicle.

    Raises ValueError for a table without t or positions, one whose columns can be read as those of one
    vehicle or of several, a time that is negative, not a number or not increasing, or times, positions and
    angles that are not in s, m and rad.
    """
    if "t" not in columns:
        raise ValueError(f"the table has no column t [s]; it has {', '.join(columns)}")
    t = np.asarray(columns["t"], dtype=np.float64)
    late = np.flatnonzero(~(np.diff(t) > 0.0))
    if not len(t) or not t[0] >= 0.0 or len(late):
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
    table = FlightTable(t, names, found)
    _check_units(table)
    return table


def _check_units(table: FlightTable) -> None:
    """Raise ValueError for times, positions or angles that are not in s, m or rad."""
    step = float(np.median(np.diff(table.t))) if len(table.t) > 1 else 0.0
    if step > LONGEST_STEP:
        raise ValueError(f"t steps by {step:g}, {LONGEST_STEP:g} s is the maximum: is it in seconds?")
    check_metres(table.names, table.vectors(POS))
    if table.has(EULER):
        _check_radians(table)


def _check_radians(table: FlightTable) -> None:
    """Raise ValueError if angles that are the attitude of a vehicle are not in radians."""
    used = ~_has_quat(table)
    for k, name in enumerate(table.names):
        tilt = float(np.nanmax(np.abs(table.vectors(EULER[:2])[used[:, k], k]), initial=0.0))
        if tilt > np.pi:
            raise ValueError(
                f"roll_rad and pitch_rad of {name} reach {tilt:g} and are its attitude: they must be "
                "radians; a column map (bag_import --columns) scales degrees by 0.0174533"
            )


def signals_of(table: FlightTable) -> dict[str, Iterator[Signal]]:
    """Return topic -> one signal per tick, for every topic that the table contains."""
    made: dict[str, Iterator[Signal]] = {"/mocap": _mocap(table)}
    if _has_attitude(table) and table.has(VEL):
        made["/state"] = _state(table)
    if table.has(REF):
        made["/reference"] = _reference(table)
    if table.has(THRUST):
        made["/command"] = _command(table)
    if _has_attitude(table) and table.has(ACC):
        made["/imu"] = _imu(table)
    return made


def _has_attitude(table: FlightTable) -> bool:
    return table.has(QUAT) or table.has(EULER)


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
    moving = [group for group in (VEL, ACC) if table.has(group)] if _has_attitude(table) else []
    groups += [group for group in (ANGLES, *moving) if group == VEL or _all_turned(table, group)]
    groups += [RATE] if moving else []
    groups += [REF, REF_VEL, YAW_REF] if table.has(REF) else []
    return {name for group in groups if table.has(group) for name in group}


def _all_turned(table: FlightTable, group: tuple[str, ...]) -> bool:
    """Return whether every vehicle with values of a group has an attitude."""
    if not table.has(group):
        return False
    known = np.isfinite(table.vectors(group)).any(axis=(0, 2))  # (n,)
    return not (known & ~np.isfinite(_quat(table)).all(axis=2).any(axis=0)).any()


def stamp(t: float) -> float:
    """Return a time [s] rounded to nanoseconds, as its stamp in a message."""
    return time_from_stamp(stamp_from_time(t))


def _mocap(table: FlightTable) -> Iterator[Signal]:
    pos, quat = table.vectors(POS), _quat(table)
    visible = np.isfinite(pos).all(axis=-1) & ~table.gap
    for row, t in enumerate(table.t):
        here = np.flatnonzero(visible[row])
        names = tuple(table.names[k] for k in here)
        yield MocapFrame(t=stamp(t), names=names, pos=pos[row, here], quat=quat[row, here])


def _state(table: FlightTable) -> Iterator[Signal]:
    pos, vel, quat, rate = table.vectors(POS), table.vectors(VEL), _quat(table), _rate(table)
    gap = table.gap
    last = np.maximum.accumulate(np.where(gap, table.t[0], table.t[:, None]), axis=0)
    status = np.where(gap, TrackStatus.COASTING, TrackStatus.TRACKED).astype(np.uint8)
    for row, t in enumerate(table.t):
        yield SwarmState(
            t=stamp(t),
            names=table.names,
            pos=pos[row],
            vel=vel[row],
            quat=quat[row],
            ang_vel_body=rate[row],
            age=t - last[row],
            status=status[row],
        )


def _reference(table: FlightTable) -> Iterator[Signal]:
    pos = table.vectors(REF)
    vel = table.vectors(REF_VEL) if table.has(REF_VEL) else np.full_like(pos, np.nan)
    acc = np.gradient(vel, table.t, axis=0)
    acc[:, [is_rare(table.t, own) for own in np.swapaxes(vel, 0, 1)]] = np.nan
    unknown = np.full(pos.shape[:2], np.nan)
    yaw = np.deg2rad(table.columns["yawref_deg"]) if table.has(("yawref_deg",)) else unknown
    for row, t in enumerate(table.t):
        yield SwarmSetpoint(
            t=stamp(t),
            names=table.names,
            pos=pos[row],
            vel=vel[row],
            acc=acc[row],
            yaw=yaw[row],
            yaw_rate=unknown[row],
            status=np.zeros(len(table.names), dtype=np.uint8),
        )


def _command(table: FlightTable) -> Iterator[Signal]:
    unknown = np.full(len(table.names), np.nan)
    for row, t in enumerate(table.t):
        yield SwarmCommand(
            t=stamp(t),
            names=table.names,
            thrust=table.columns["thrust_cmd"][row],
            roll=unknown,
            pitch=unknown,
            yaw_rate=unknown,
            status=np.zeros(len(table.names), dtype=np.uint8),
        )


def _imu(table: FlightTable) -> Iterator[Signal]:
    pull = table.vectors(ACC) + np.array([0.0, 0.0, GRAVITY])
    force, rate = rotate_inverse(_quat(table), pull), _rate(table)
    for row, t in enumerate(table.t):
        yield SwarmImu(t=stamp(t), names=table.names, specific_force_body=force[row], ang_vel_body=rate[row])


def _rate(table: FlightTable) -> Array:
    return table.vectors(RATE) if table.has(RATE) else np.full((len(table.t), len(table.names), 3), np.nan)


def _quat(table: FlightTable) -> Array:
    quat = np.full((len(table.t), len(table.names), 4), np.nan)
    if table.has(EULER):
        quat = quat_from_euler(*(table.columns[name] for name in EULER))
    if table.has(QUAT):
        quat = np.where(_has_quat(table)[..., None], normalised(table.vectors(QUAT)), quat)
    return quat


def _has_quat(table: FlightTable) -> Mask:
    """Return the rows with a quaternion, (T, n)."""
    if not table.has(QUAT):
        return np.zeros((len(table.t), len(table.names)), dtype=bool)
    return np.asarray(np.isfinite(normalised(table.vectors(QUAT))).all(axis=-1))
