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

from q2q_model.palette import VEHICLES
from q2q_model.signals.values import Array
from q2q_sim.replay_page.even_samples import even_quats, even_samples, even_times
from q2q_sim.replay_page.replay_run import ReplayRun

RATE_HZ = 50.0
"""Highest rate of samples [Hz]: a browser draws 60 pictures per second and interpolates."""
STEPS = {"pos": 5e-4, "quat": 5e-4, "ref": 5e-4, "mocap": 5e-4, "downwash": 5e-3, "thrust": 5e-3}
"""Rounding of each quantity, in its unit: half a millimetre, 0.06 degrees, 5 mm/s^2, half a percent."""
MISSING = 65535
"""Code of a value that was not recorded."""

PackedValues = Mapping[str, object]


def packed_run(run: ReplayRun, rate_hz: float = RATE_HZ) -> PackedValues:
    """Return a run as plain values for JSON, sampled at `rate_hz` or its own rate, whichever is lower.

    Raises:
        ValueError: the stamps span more than fits a page, as by a clock that was set.
    """
    rate = min(rate_hz, _own_rate(run.t))
    at = even_times(run.t, rate)
    return {
        "name": run.name,
        "names": run.names,
        "since": run.since,
        "rate": rate,
        "count": len(at),
        "palette": VEHICLES,
        "arm": run.arm,
        "zone": asdict(run.zone),
        "wakeSpeed": run.wake_speed if np.isfinite(run.wake_speed) else None,
        "verdict": run.verdict,
        "missing": run.missing,
        "note": run.note,
        "events": [{"t": one.t - float(run.t[0]), "words": one.words} for one in run.events],
        "outliers": _outliers(run),
        "channels": {
            name: _packed(values, STEPS[name])
            for name, values in _channels(run, at).items()
            if np.isfinite(values).any()
        },
    }


def _channels(run: ReplayRun, at: Array) -> dict[str, Array]:
    """Return the quantities at even times by name, (T, n, width) each; w of quat follows from x, y, z."""
    quantities = {
        "pos": run.pos,
        "ref": run.ref_pos,
        "mocap": np.where(run.rejected[..., None], np.nan, run.mocap_pos),
        "downwash": run.downwash,
        "thrust": run.thrust[..., None],
    }
    channels = {name: even_samples(run.t, values, at) for name, values in quantities.items()}
    return channels | {"quat": even_quats(run.t, run.quat, at)[..., :3]}


def _outliers(run: ReplayRun) -> list[list[float]]:
    """Return time since the start [s], vehicle and position [m] of every rejected sample."""
    ticks, vehicles = np.nonzero(run.rejected)
    samples = np.column_stack([run.t[ticks] - run.t[0], vehicles, run.mocap_pos[ticks, vehicles]])
    return [[round(value, 4) for value in row] for row in samples.tolist()]


def _own_rate(t: Array) -> float:
    return float(1.0 / np.median(np.diff(t))) if len(t) > 1 else RATE_HZ


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
