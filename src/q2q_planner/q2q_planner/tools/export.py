"""Export of a plan: sampled as CSV, and as polynomials for Crazyswarm2's upload.

Crazyswarm2's `uploadTrajectory` reads one file per vehicle: a header and one row per piece, its duration and
the ascending coefficients of x, y, z, yaw, degree 7 each (crazyflie_py, `uav_trajectory.Trajectory.loadcsv`).
"""

import csv
from collections.abc import Iterable, Mapping, Sequence
from math import ceil
from pathlib import Path

import numpy as np

from q2q_model.documents.written_file import naming_written
from q2q_model.signals.values import Array
from q2q_model.trajectory.polynomials import AXES, SwarmPlan, Trajectory, setpoint_at
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints

UPLOAD_ORDER = 8
"""Coefficients per piece and axis: degree 7."""

MOST_PIECES = 31
"""Pieces that fit into the firmware's trajectory memory, 4096 bytes, 132 each (firmware:
src/modules/interface/crtp_commander_high_level.h, TRAJECTORY_MEMORY_SIZE)."""

SAMPLE_STEP = 0.01
"""Period of the sampled CSV [s]: 100 Hz."""

COLUMNS = ("t", "name", "x", "y", "z", "vx", "vy", "vz", "ax", "ay", "az", "yaw", "yaw_rate")


def write_samples(path: Path, plan: SwarmPlan) -> None:
    """Write every vehicle's setpoint at 100 Hz in SI units, one row per vehicle and tick.

    The folders above the file are created.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    with naming_written(path), path.open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file)
        table.writerow(COLUMNS)
        for t in exported_times(plan.duration):
            setpoint = setpoint_at(plan, t)
            for row, name in enumerate(plan.names):
                moves = (*setpoint.pos[row], *setpoint.vel[row], *setpoint.acc[row])
                numbers = (*moves, setpoint.yaw[row], setpoint.yaw_rate[row])
                table.writerow([repr(setpoint.t), name, *(repr(float(number)) for number in numbers)])


def exported_times(duration: float) -> list[float]:
    """Return the times of the samples [s]: every SAMPLE_STEP, and the end."""
    steps = ceil(duration / SAMPLE_STEP - 1e-6)  # rounding of a duration adds no step
    return [*(step * SAMPLE_STEP for step in range(steps)), duration]


def check_upload_of(swarm: Sequence[VehicleWaypoints], folder: Path, others: Iterable[Path | None]) -> None:
    """Check, before the search, that waypoints can be uploaded, and that their files are not `others`.

    Raises:
        ValueError: naming the vehicle and what is allowed.
    """
    taken = {path.resolve() for path in others if path}
    for vehicle in swarm:
        check_pieces(vehicle.name, len(vehicle.waypoints) - 1)
        path = upload_path(folder, vehicle.name)
        if path.resolve() in taken:
            message = f"--upload writes {path} for {vehicle.name}"
            raise ValueError(f"{message}: give the other output another name")


def check_pieces(name: str, pieces: int) -> None:
    """Raise ValueError if a vehicle's memory does not hold that many pieces."""
    if pieces > MOST_PIECES:
        given = f"{name}: {pieces} pieces; must be at most {MOST_PIECES}, a Crazyflie's memory"
        raise ValueError(f"{given}: give fewer waypoints (avoidance splits a segment into several pieces)")


def upload_path(folder: Path, name: str) -> Path:
    """Return the file of a vehicle's upload."""
    return folder / f"{name}.csv"


def upload_rows(plan: SwarmPlan) -> dict[str, Array]:
    """Return each vehicle's pieces, (pieces, 1 + AXES * UPLOAD_ORDER): duration, then coefficients.

    Raises:
        ValueError: a piece has a degree above the firmware's 7, or there are too many pieces.
    """
    return {name: _pieces_of(name, one) for name, one in zip(plan.names, plan.trajectories, strict=True)}


def _pieces_of(name: str, trajectory: Trajectory) -> Array:
    order = trajectory.coefficients.shape[-1]
    if order > UPLOAD_ORDER and trajectory.coefficients[..., UPLOAD_ORDER:].any():
        raise ValueError(f"{name}: pieces of degree {order - 1}; must be at most 7 for Crazyswarm2")
    pieces = len(trajectory.durations)
    check_pieces(name, pieces)
    powers = np.zeros((pieces, AXES, UPLOAD_ORDER))
    powers[..., : min(order, UPLOAD_ORDER)] = trajectory.coefficients[..., :UPLOAD_ORDER]
    return np.column_stack([trajectory.durations, powers.reshape(pieces, -1)])


def write_uploads(folder: Path, rows: Mapping[str, Array]) -> None:
    """Write `<name>.csv` for each vehicle of `upload_rows`, to be uploaded by Crazyswarm2."""
    header = ["Duration", *(f"{axis}^{k}" for axis in ("x", "y", "z", "yaw") for k in range(UPLOAD_ORDER))]
    folder.mkdir(parents=True, exist_ok=True)
    for name, pieces in rows.items():
        path = upload_path(folder, name)
        with naming_written(path), path.open("w", newline="", encoding="utf-8") as file:
            table = csv.writer(file)
            table.writerow(header)
            for row in pieces:
                table.writerow([repr(float(number)) for number in row])
