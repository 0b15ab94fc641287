"""Run as JSON for the page: quantities rounded to integers, differenced over time and compressed.

    code   = round((x - low) / step), 65535 where nothing was recorded
    packed = zlib(low bytes of all differences, then their high bytes), differences as zigzag 16-bit integers

Positions keep half a millimetre. A run is sampled on an even grid of at most `RATE_HZ`.
"""

import zlib
from base64 import b64encode
from collections.abc import Mapping
from dataclasses import asdict

import numpy as np
from numpy.typing import NDArray

from q2q_model.flights.interpolated_gaps import nearest_samples
from q2q_model.palette import VEHICLES
from q2q_model.signals.values import Array
from q2q_sim.replay_page.replay_run import ReplayRun

RATE_HZ = 50.0
"""Highest rate of samples [Hz]: a browser draws 60 pictures per second and interpolates."""
STEPS = {"pos": 5e-4, "quat": 5e-4, "ref": 5e-4, "mocap": 5e-4, "downwash": 5e-3, "thrust": 5e-3}
"""Rounding of each quantity, in its unit: half a millimetre, 0.06 degrees, 5 mm/s^2, half a percent."""
MISSING = 65535
"""Code of a value that was not recorded."""
MOST_SAMPLES = 1_000_000
"""Most samples of a run: five and a half hours at the highest rate."""
HOLE_S = 0.05
"""Distance from the nearest recorded tick beyond which a sample is missing [s]."""

PackedValues = Mapping[str, object]


def packed_run(run: ReplayRun, rate_hz: float = RATE_HZ) -> PackedValues:
    """Return a run as plain values for JSON, sampled at `rate_hz` or its own rate, whichever is lower.

    Raises:
        ValueError: the stamps span more than `MOST_SAMPLES`, as by a clock that was set.
    """
    rate = min(rate_hz, _own_rate(run.t))
    rows, known = _even_rows(run.t, rate)
    channels = {name: values[rows] for name, values in _channels(run).items() if np.isfinite(values).any()}
    for values in channels.values():
        values[~known] = np.nan
    return {
        "name": run.name,
        "names": run.names,
        "since": run.since,
        "rate": rate,
        "count": len(rows),
        "palette": VEHICLES,
        "arm": run.arm,
        "zone": asdict(run.zone),
        "wakeSpeed": run.wake_speed if np.isfinite(run.wake_speed) else None,
        "verdict": run.verdict,
        "missing": run.missing,
        "note": run.note,
        "events": [{"t": one.t - float(run.t[0]), "words": one.words} for one in run.events],
        "outliers": _outliers(run),
        "channels": {name: _packed(values, STEPS[name]) for name, values in channels.items()},
    }


def _channels(run: ReplayRun) -> dict[str, Array]:
    """Return the quantities by name, (T, n, width) each."""
    upright = np.where(run.quat[..., 3:] < 0.0, -run.quat, run.quat)  # w follows from x, y, z
    accepted = np.where(run.rejected[..., None], np.nan, run.mocap_pos)
    return {
        "pos": run.pos,
        "quat": upright[..., :3],
        "ref": run.ref_pos,
        "mocap": accepted,
        "downwash": run.downwash,
        "thrust": run.thrust[..., None],
    }


def _outliers(run: ReplayRun) -> list[list[float]]:
    """Return time since the start [s], vehicle and position [m] of every rejected sample."""
    ticks, vehicles = np.nonzero(run.rejected)
    samples = np.column_stack([run.t[ticks] - run.t[0], vehicles, run.mocap_pos[ticks, vehicles]])
    return [[round(value, 4) for value in row] for row in samples.tolist()]


def _own_rate(t: Array) -> float:
    return float(1.0 / np.median(np.diff(t))) if len(t) > 1 else RATE_HZ


def _even_rows(t: Array, rate: float) -> tuple[NDArray[np.intp], NDArray[np.bool_]]:
    """Return the nearest row of each sample on an even grid, and whether one is near enough."""
    _check_span(t, rate)
    grid = t[0] + np.arange(int((t[-1] - t[0]) * rate + 1e-6) + 1) / rate  # the last stamp too, if rounded
    rows = nearest_samples(t, grid)
    return rows, np.abs(t[rows] - grid) <= max(HOLE_S, 1.0 / rate)


def _check_span(t: Array, rate: float) -> None:
    if (span := float(t[-1] - t[0])) * rate > MOST_SAMPLES:
        at = int(np.argmax(np.diff(t)))
        raise ValueError(
            f"the stamps span {span:.6g} s, with a gap of {t[at + 1] - t[at]:.6g} s after {t[at]:.6g} s: "
            f"at most {MOST_SAMPLES / rate:.6g} s are replayed (replay_page replays a part: --start, --end)"
        )


def _packed(values: Array, step: float) -> PackedValues:
    """Return (T, n, width) values as width, low, step and base64."""
    low = float(np.nanmin(values))
    step = max(step, (float(np.nanmax(values)) - low) / (MISSING - 1))
    with np.errstate(invalid="ignore"):
        codes = np.where(np.isfinite(values), np.rint((values - low) / step), MISSING).astype(np.uint16)
    series = np.moveaxis(codes, 0, -1)  # (n, width, T)
    steps = np.diff(series, axis=-1, prepend=np.uint16(0)).view(np.int16)
    zigzag = ((steps << 1) ^ (steps >> 15)).view(np.uint16)
    planes = (zigzag & 0xFF).astype(np.uint8).tobytes() + (zigzag >> 8).astype(np.uint8).tobytes()
    data = b64encode(zlib.compress(planes, 9)).decode()
    return {"width": values.shape[-1], "low": low, "step": step, "data": data}
