"""Columns of recorded flights: of two vehicles with all that is read, or of positions only."""

from pathlib import Path

import numpy as np

from q2q_model.signals.values import Array

ALL = (
    *("x", "y", "z", "vx", "vy", "vz", "ax", "ay", "az", "roll", "pitch", "yaw", "qx", "qy", "qz", "qw"),
    *("wp", "wq", "wr", "xref", "yref", "zref", "vxref", "vyref", "vzref", "thrust_cmd"),
    *("pwm1", "pwm2", "pwm3", "pwm4", "vbat", "fa_ff", "thrust_est", "faz_est", "gap"),
)


def table_columns(ticks: int = 40) -> dict[str, Array]:
    """Return random columns of cf50 and cf51, which has a gap of 5 rows."""
    rng = np.random.default_rng(0)
    columns = {"t": 0.01 * np.arange(1, ticks + 1)}
    for name in ("cf50", "cf51"):
        columns |= {f"{name}_{key}": rng.normal(size=ticks) for key in ALL}
        quat = rng.normal(size=(ticks, 4))
        quat /= np.linalg.norm(quat, axis=1, keepdims=True)
        columns |= {f"{name}_{key}": quat[:, k] for k, key in enumerate(("qx", "qy", "qz", "qw"))}
        columns[f"{name}_gap"] = np.zeros(ticks)
    columns["cf51_gap"][10:15] = 1.0
    return columns


def write_csv(columns: dict[str, Array], path: Path) -> None:
    """Write columns to the last digit."""
    rows = np.stack(list(columns.values()), axis=1)
    np.savetxt(path, rows, delimiter=",", header=",".join(columns), comments="", fmt="%.17g")


def vectors(*prefixes: str) -> dict[str, Array]:
    """Return t and a vector of each prefix: the x of the k-th is k."""
    t = 0.01 * np.arange(40)
    return {"t": t} | {f"{one}{axis}": k + 0.0 * t for k, one in enumerate(prefixes) for axis in "xyz"}
