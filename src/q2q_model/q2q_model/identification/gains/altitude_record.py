"""Altitude record of a flight, the data of section 3: positions, altitude reference and command.

| symbol | name | meaning [unit] |
|---|---|---|
| r | pos | position [m], world, (T, n, 3) |
| z_ref z_ref' z_ref'' | ref | altitude reference and its derivatives [m], [m/s], [m/s^2], (T, n, 3) |
| U1 b_z / m - g | commanded_acc | commanded vertical acceleration [m/s^2], (T, n) |

A record has no hole: what a vehicle did in one is not known, and it ends in a state of its own. A flight with
holes (no frame, a vehicle out of sight, a jump of the clock, two flights in one bag) is one record from each
hole to the next. A vehicle that only stands there is no part of it.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from q2q_model.counted import counted
from q2q_model.flights.flight import Flight, of_rows, of_vehicles
from q2q_model.flights.interpolated_gaps import resample
from q2q_model.flights.outliers import find_outliers, repair
from q2q_model.flights.reference_remarks import reference_remarks
from q2q_model.flights.sampled_reference import SampledReference, flown_reference
from q2q_model.flights.unit_check import check_flight_metres
from q2q_model.geometry.rotations import rotate
from q2q_model.identification.gains.velocity_limit import is_differentiated
from q2q_model.signals.values import Array, Mask, Names, Rows
from q2q_model.vehicle.constants import GRAVITY, Vehicle

UP = np.array([0.0, 0.0, 1.0])
"""Body z of a level vehicle."""
SHORTEST = 2.0
"""Minimum duration of a record [s], about the time constant of the altitude loop."""
HOLE_S, HOLE_PERIODS = 0.3, 3.0
"""Time without a row from which there is a hole [s], and at least in median periods: a third of the time
constant of the altitude loop."""
STILL = 0.02
"""Distance from its median place that a vehicle on the ground does not leave [m]: far above the noise of
motion capture, and below the wander of a vehicle that takes off."""
MOSTLY = 0.99
"""Share of positions within that distance [-]; others are outliers."""
STANDING = 0.25
"""Share of the weight below which a commanded thrust is that of a vehicle on the ground [-]: in recorded
flights, commands in the air are 0.64 or more."""
LEAST_UP = 0.5
"""Minimum median of the vertical component of body z [-]: a tilt of 60 degrees."""


@dataclass(frozen=True, slots=True)
class AltitudeRecord:
    """Altitudes of one flight on an even grid, without gaps."""

    name: str
    names: Names
    dt: float
    t: Array
    """[s], (T,)."""
    pos: Array
    vel: Array
    """Velocity [m/s], world, (T, n, 3)."""
    axis: Array
    """Body z, world, (T, n, 3)."""
    ref: Array
    commanded_acc: Array
    """Commanded vertical acceleration in flight [m/s^2], (T, n); NaN where command, position or reference was
    not recorded, and on the ground."""
    feed_forward: Array
    """Downwash compensated by the controller [m/s^2], along z, (T, n); NaN where not recorded."""
    added_acc: Array
    """Acceleration by feed-forward and a constant, added to (13), along z [m/s^2], (T, n); 0 if unknown."""
    outliers: int
    """Number of outliers among the motion capture samples."""
    samples: int
    rates_fitted: bool = False
    """Whether z_ref' and z_ref'' were not recorded: what of them the controller had is not known."""
    acc_differentiated: bool = False
    """Whether z_ref'' is the differences of z_ref': at a limit of it, the controller was given another."""

    @property
    def deviation(self) -> Array:
        """Return z - z_ref [m], (T, n)."""
        return self.pos[..., 2] - self.ref[..., 0]

    @property
    def start(self) -> Array:
        """Return z - z_ref [m] and its rate [m/s] at the first tick, (2, n)."""
        return np.stack([self.deviation[0], self.vel[0, :, 2] - self.ref[0, :, 1]])

    @property
    def jerk(self) -> Array:
        """Return z_ref''' [m/s^3], (T, n)."""
        return np.asarray(np.gradient(self.ref[..., 2], self.dt, axis=0))


def flight_numbers(records: Sequence[AltitudeRecord]) -> list[int]:
    """Return for each record the number of its flight: those of one name are pieces of one flight."""
    names = list(dict.fromkeys(record.name for record in records))
    return [names.index(record.name) for record in records]


def in_clear_air(record: AltitudeRecord, distance: float) -> Mask:
    """Return the ticks at which no other vehicle is within a horizontal distance [m], (T, n)."""
    rel = record.pos[:, None] - record.pos[:, :, None]  # (T, n, n, 3)
    apart = np.hypot(rel[..., 0], rel[..., 1]) > distance
    return np.asarray((apart | np.eye(len(record.names), dtype=np.bool_)).all(axis=2))


def decimate(record: AltitudeRecord, every: int) -> AltitudeRecord:
    """Return every `every`-th tick of a record."""
    rows = slice(None, None, every)
    return replace(
        record,
        dt=every * record.dt,
        t=record.t[rows],
        pos=record.pos[rows],
        vel=record.vel[rows],
        axis=record.axis[rows],
        ref=record.ref[rows],
        commanded_acc=record.commanded_acc[rows],
        feed_forward=record.feed_forward[rows],
        added_acc=record.added_acc[rows],
    )


def altitude_records(flight: Flight, vehicle: Vehicle) -> tuple[list[AltitudeRecord], list[str]]:
    """Return the altitude records of a flight, from hole to hole, and remarks on holes and vehicles left out.

    Raises:
        ValueError: as `altitude_record`, or no 2 s between holes.
    """
    standing = _standing(flight)
    if len(standing) == len(flight.names):
        standing = []
    flown = of_vehicles(flight, tuple(name for name in flight.names if name not in standing))
    pieces, holes = _between_holes(flown)
    records, given = zip(*(_record_and_reference(piece, vehicle) for piece in pieces), strict=True)
    stood = [f"{flight.name}: {', '.join(standing)} never flew: left out of the gains"] if standing else []
    return list(records), [*stood, *holes, *reference_remarks(flown.name, flown.names, given)]


def _standing(flight: Flight) -> list[str]:
    """Return the vehicles without a reference or a thrust that stay where they are."""
    known, found = _referred(flight), []
    pos = np.where(np.isfinite(flight.pos), flight.pos, flight.mocap_pos)
    for i, name in enumerate(flight.names):
        place = pos[np.isfinite(pos[:, i]).all(axis=1), i]
        if known[:, i].any() or (flight.thrust[:, i] > 0.0).any() or not len(place):
            continue
        away = np.abs(place - np.median(place, axis=0)).max(axis=1)
        if np.quantile(away, MOSTLY) < STILL:
            found.append(name)
    return found


def _between_holes(flight: Flight) -> tuple[list[Flight], list[str]]:
    """Return the pieces of a flight from hole to hole that are long enough, and a remark on holes."""
    whole = _whole_rows(flight)
    t, steps = flight.t[whole], np.diff(flight.t[whole])
    usual = float(np.median(steps)) if steps.size else 0.0
    holes = np.flatnonzero(steps > max(HOLE_S, HOLE_PERIODS * usual))
    if not holes.size:
        return [flight], []
    ends = zip([0, *(holes + 1)], [*holes, t.size - 1], strict=True)
    parts = [slice(int(whole[first]), int(whole[last]) + 1) for first, last in ends]
    long = [part for part in parts if flight.t[part][-1] - flight.t[part][0] >= SHORTEST]
    if not long:
        raise _too_short(flight)
    remark = _holes_note(flight.name, t[holes], steps[holes], len(parts) - len(long))
    return [of_rows(flight, part) for part in long], [remark]


def _holes_note(name: str, t: Array, seconds: Array, left_out: int) -> str:
    worst = int(np.argmax(seconds))
    which = f"hole of {seconds[worst]:.1f} s at t = {t[worst]:.2f} s"
    several = f"{len(t)} holes, the longest a {which}" if len(t) > 1 else which
    short = f"; without {counted(left_out, 'piece')} shorter than {SHORTEST:g} s" if left_out else ""
    return f"{name}: {several}, or a jump of the clock: nothing is inferred across it{short}"


def altitude_record(flight: Flight, vehicle: Vehicle) -> AltitudeRecord:
    """Return the altitude record of a flight of identical vehicles; holes are interpolated.

    Filtered states, the input of the controller, are used where recorded; else motion capture with
    interpolated outliers (section 2.2) and its differences.

    Raises:
        ValueError: no reference, positions not in metres, less than 2 s of both, or an attitude that is not
            upright.
    """
    return _record_and_reference(flight, vehicle)[0]


def _record_and_reference(flight: Flight, vehicle: Vehicle) -> tuple[AltitudeRecord, SampledReference]:
    check_upright(flight)
    check_flight_metres(flight)
    mocap = np.where(np.isfinite(flight.mocap_pos), flight.mocap_pos, np.nan)
    visible, placed = _finite_rows(mocap), _placed(flight)
    bad = find_outliers(flight.t, mocap)
    rows = _common_rows(flight)
    given = flown_reference(flight)
    ref = np.stack([given.pos[..., 2], given.vel[..., 2], given.acc[..., 2]], axis=-1)
    repaired = repair(flight.t, mocap, bad)
    pos = np.where(np.isfinite(flight.pos), flight.pos, repaired)
    vel = np.where(np.isfinite(flight.vel), flight.vel, np.gradient(repaired, flight.t, axis=0))
    t = np.arange(flight.t[rows][0], flight.t[rows][-1] + 1e-9, dt := float(np.median(np.diff(flight.t))))
    axis, commanded_acc = _attitude(flight), _commanded_acc(flight, vehicle, placed & given.sure)
    pos, vel, axis, ref = (resample(flight.t, values, t) for values in (pos, vel, axis, ref))
    nearest = np.clip(np.searchsorted(flight.t, t - 0.5 * dt), 0, flight.t.size - 1)
    record = AltitudeRecord(
        name=flight.name,
        names=flight.names,
        dt=dt,
        t=t,
        pos=pos,
        vel=vel,
        axis=axis,
        ref=ref,
        commanded_acc=commanded_acc[nearest],
        feed_forward=flight.eta[nearest, :, 2],
        added_acc=np.zeros((t.size, len(flight.names))),
        outliers=int((bad & visible).sum()),
        samples=int(visible.sum()),
        rates_fitted=bool(given.fitted.any()),
        acc_differentiated=is_differentiated(flight.t, given.vel[..., 2], given.acc[..., 2]),
    )
    return record, given


def check_upright(flight: Flight) -> None:
    """Raise ValueError if body z of a vehicle does not point up in the median of its flight."""
    up = _attitude(flight)[..., 2]
    for i, name in enumerate(flight.names):
        flies = flight.thrust[:, i] > 0.0
        median = float(np.median(up[flies, i] if flies.any() else up[:, i]))
        if median < LEAST_UP:
            raise ValueError(
                f"flight {flight.name}: body z of {name} points {median:.2f} upwards in the median, "
                f"{LEAST_UP:g} or more is expected: are quaternions in the order x y z w, and is z up?"
            )


def _referred(flight: Flight) -> Mask:
    """Return where there is an altitude reference, also one that is held, (T, n)."""
    return np.asarray(np.isfinite(flight.safe_pos[..., 2]) | np.isfinite(flight.ref_pos[..., 2]))


def _placed(flight: Flight) -> Mask:
    """Return where a position is known, (T, n)."""
    return _finite_rows(flight.mocap_pos) | _finite_rows(flight.pos)


def _whole_rows(flight: Flight) -> Rows:
    """Return the rows with position and reference of every vehicle, (k,)."""
    return np.flatnonzero((_placed(flight) & _referred(flight)).all(axis=1))


def _common_rows(flight: Flight) -> slice:
    """Return the rows from the first to the last with position and reference of every vehicle."""
    whole = _whole_rows(flight)
    if whole.size == 0 or flight.t[whole[-1]] - flight.t[whole[0]] < SHORTEST:
        raise _too_short(flight)
    return slice(int(whole[0]), int(whole[-1]) + 1)


def _too_short(flight: Flight) -> ValueError:
    known = {"reference": _referred(flight), "position": _placed(flight)}
    lacking = [
        f"no {what} of {name}"
        for what, rows in known.items()
        for name, own in zip(flight.names, rows.T, strict=True)
        if not own.any()
    ]
    which = f": there is {', '.join(lacking)}" if lacking else ""
    return ValueError(
        f"flight {flight.name}: positions and references of {', '.join(flight.names)} never last for "
        f"{SHORTEST} s together{which}; record the topics mocap (or state) and reference of one flight"
    )


def _attitude(flight: Flight) -> Array:
    quat = np.where(np.isfinite(flight.quat), flight.quat, flight.mocap_quat)
    axis = rotate(np.where(np.isfinite(quat), quat, [0.0, 0.0, 0.0, 1.0]), UP)
    return np.asarray(axis)


def _commanded_acc(flight: Flight, vehicle: Vehicle, known: Mask) -> Array:
    acc = flight.thrust / vehicle.mass * _attitude(flight)[..., 2] - GRAVITY
    flies = flight.thrust > STANDING * vehicle.hover_thrust
    return np.asarray(np.where(known & flies, acc, np.nan))


def _finite_rows(values: Array) -> Mask:
    return np.asarray(np.isfinite(values).all(axis=-1))
