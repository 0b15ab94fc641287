"""Export of a plan: sampled as CSV, and as polynomials for Crazyswarm2's upload.

Crazyswarm2's `uploadTrajectory` reads one file per vehicle: a header and one row per piece, its duration and
the ascending coefficients of x, y, z, yaw, degree 7 each (crazyflie_py, `uav_trajectory.Trajectory.loadcsv`).
"""

import csv
from pathlib import Path

import numpy as np

from q2q_model.trajectory.polynomials import AXES, SwarmPlan, setpoint_at

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
    with path.open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file)
        table.writerow(COLUMNS)
        for tick in range(int(np.ceil(plan.duration / SAMPLE_STEP)) + 1):
            setpoint = setpoint_at(plan, min(tick * SAMPLE_STEP, plan.duration))
            for row, name in enumerate(plan.names):
                moves = (*setpoint.pos[row], *setpoint.vel[row], *setpoint.acc[row])
                numbers = (*moves, setpoint.yaw[row], setpoint.yaw_rate[row])
                table.writerow([repr(setpoint.t), name, *(repr(float(number)) for number in numbers)])


def write_uploads(folder: Path, plan: SwarmPlan) -> None:
    """Write `<name>.csv` for each vehicle, to be uploaded by Crazyswarm2.

    Raises:
        ValueError: a piece has a degree above the firmware's 7, or there are too many pieces.
    """
    header = ["Duration", *(f"{axis}^{k}" for axis in ("x", "y", "z", "yaw") for k in range(UPLOAD_ORDER))]
    folder.mkdir(parents=True, exist_ok=True)
    for name, trajectory in zip(plan.names, plan.trajectories, strict=True):
        order = trajectory.coefficients.shape[-1]
        if order > UPLOAD_ORDER and trajectory.coefficients[..., UPLOAD_ORDER:].any():
            raise ValueError(f"{name}: pieces of degree {order - 1}; Crazyswarm2 uploads at most degree 7")
        if len(trajectory.durations) > MOST_PIECES:
            pieces = f"{name}: {len(trajectory.durations)} pieces"
            raise ValueError(f"{pieces}; a Crazyflie's memory holds {MOST_PIECES}: plan a shorter flight")
        rows = np.zeros((len(trajectory.durations), AXES, UPLOAD_ORDER))
        rows[..., : min(order, UPLOAD_ORDER)] = trajectory.coefficients[..., :UPLOAD_ORDER]
        with (folder / f"{name}.csv").open("w", newline="", encoding="utf-8") as file:
            table = csv.writer(file)
            table.writerow(header)
            for duration, row in zip(trajectory.durations, rows, strict=True):
                table.writerow([repr(float(duration)), *(repr(float(number)) for number in row.ravel())])
