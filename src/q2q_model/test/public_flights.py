"""Pushes on the vehicles of the public flights, by family."""

import os
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from q2q_model.flights.flight_log import FlightLog
from q2q_model.geometry.rotations import rotate
from q2q_model.identification.push.along_flight import Motion
from q2q_model.identification.push.log_mass import LOG_MASS
from q2q_model.identification.push.push_samples import (
    PushRecord,
    PushSamples,
    push_samples,
)
from q2q_model.identification.push.recorded_push import push_of_log
from q2q_model.signals.values import Array

DATA = Path(os.environ.get("Q2Q_DATA", "../shared/data")) / "neural_swarm"
needs_flights = pytest.mark.skipif(not DATA.is_dir(), reason=f"no recorded flights in {DATA}: set Q2Q_DATA")
OFF, ON = "dc19", "dc21"
"""Families: feed-forward off, on. Never pooled."""


@cache
def real_samples(family: str) -> dict[str, list[PushSamples]]:
    """Return the samples of all flights of a family with more than one vehicle."""
    found = {
        path.stem: push_samples(_push_record(path)) for path in sorted(DATA.glob(f"{family}*_ss*.parquet"))
    }
    return {name: samples for name, samples in found.items() if samples}


def _push_record(path: Path) -> PushRecord:
    from pyarrow import parquet

    table = parquet.read_table(path)
    names = tuple(sorted({name[:4] for name in table.column_names if name.startswith("cf")}))

    def columns(*expected: str) -> Array:
        return np.array(
            [[table[f"{name}_{one}"].to_numpy() for one in expected] for name in names], dtype=float
        )

    t = np.asarray(table["t"].to_numpy(), dtype=float)
    expected = (("x", "y", "z"), ("vx", "vy", "vz"), ("qx", "qy", "qz", "qw"))
    pos, vel, quat = (columns(*some).transpose(2, 0, 1) for some in expected)
    logged = ("faz_est", "gap", "pwm1", "pwm2", "pwm3", "pwm4")
    log = FlightLog(t, names, logged, ("",) * 6, columns(*logged).transpose(2, 0, 1))
    motion = Motion(t, pos, vel, rotate(quat, np.array([0.0, 0.0, 1.0])))
    return push_of_log(path.stem, log, motion, LOG_MASS)
