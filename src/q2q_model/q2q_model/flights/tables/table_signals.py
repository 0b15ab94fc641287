"""Signals of a flight table.

| columns | become |
|---|---|
| x y z, qx qy qz qw or roll_rad pitch_rad yaw_rad | mocap; not where `gap` is set: it is interpolated |
| vx vy vz (with the above), wp wq wr | state, as estimated onboard; COASTING in a gap |
| xref yref zref, vxref vyref vzref, yawref_deg | reference; acceleration by differences, unless held |
| thrust_cmd | command; roll, pitch and yaw rate are not logged: NaN |
| ax ay az (with an attitude), wp wq wr | imu: R(q)^T (a + g e_z), because az excludes gravity |
| all others, and those of a row above in part | the log (table_log), under their own names |

Plain roll pitch yaw, which may be degrees, are no attitude; next to one they repeat it. Rates that are absent
are NaN.
"""

from collections.abc import Iterator

import numpy as np

from q2q_model.flights.masks_over_time import last_time
from q2q_model.flights.sampled_reference import is_rare
from q2q_model.flights.tables.flight_table import (
    ACC,
    POS,
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
from q2q_model.geometry.rotations import rotate_inverse
from q2q_model.signals.layout import Signal
from q2q_model.signals.stamps import stamp_from_time, time_from_stamp
from q2q_model.signals.values import (
    Array,
    MocapFrame,
    SwarmCommand,
    SwarmImu,
    SwarmSetpoint,
    SwarmState,
    TrackStatus,
)
from q2q_model.vehicle.constants import GRAVITY

LACKED = {"reference": ("yaw_rate",), "command": ("roll", "pitch", "yaw_rate")}
"""Topic -> what no table has: it is NaN in all signals."""


def signals_of(table: FlightTable) -> dict[str, Iterator[Signal]]:
    """Return topic -> one signal per tick, for every topic that the table contains."""
    made: dict[str, Iterator[Signal]] = {"/mocap": _mocap(table)}
    if has_attitude(table) and table.has(VEL):
        made["/state"] = _state(table)
    if table.has(REF):
        made["/reference"] = _reference(table)
    if table.has(THRUST):
        made["/command"] = _command(table)
    if has_attitude(table) and table.has(ACC):
        made["/imu"] = _imu(table)
    return made


def stamp(t: float) -> float:
    """Return a time [s] rounded to nanoseconds, as its stamp in a message."""
    return time_from_stamp(stamp_from_time(t))


def _mocap(table: FlightTable) -> Iterator[Signal]:
    pos, quat = table.vectors(POS), attitude(table)
    visible = np.isfinite(pos).all(axis=-1) & ~table.gap
    for row, t in enumerate(table.t):
        here = np.flatnonzero(visible[row])
        names = tuple(table.names[k] for k in here)
        yield MocapFrame(t=stamp(t), names=names, pos=pos[row, here], quat=quat[row, here])


def _state(table: FlightTable) -> Iterator[Signal]:
    pos, vel, quat, rate = table.vectors(POS), table.vectors(VEL), attitude(table), _rate(table)
    gap = table.gap
    last = np.maximum(last_time(~gap, table.t), table.t[0])
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
    yaw = np.deg2rad(table.columns["yawref_deg"]) if table.has(YAW_REF) else unknown
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
    force, rate = rotate_inverse(attitude(table), pull), _rate(table)
    for row, t in enumerate(table.t):
        yield SwarmImu(t=stamp(t), names=table.names, specific_force_body=force[row], ang_vel_body=rate[row])


def _rate(table: FlightTable) -> Array:
    return table.vectors(RATE) if table.has(RATE) else np.full((len(table.t), len(table.names), 3), np.nan)
