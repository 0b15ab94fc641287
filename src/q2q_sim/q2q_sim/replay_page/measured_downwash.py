"""Downwash of a recorded flight's replay, as its accelerometers measured it."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.ndimage import uniform_filter1d

from q2q_model.identification.push.push_samples import PushRecord, push_samples
from q2q_sim.replay_page.replay_run import ReplayRun

SMOOTHED = 15
"""Ticks over which the measured push is averaged for the eye: 0.15 s at 100 Hz."""
NOTE = "Downwash is measured by accelerometers, while a vehicle is under another."


def with_measured_downwash(run: ReplayRun, measure: Callable[[], PushRecord | None]) -> ReplayRun:
    """Return a run that records no downwash with the measured one, along z; 0 while in clear air.

    A run that has one, or was measured in clear air only, is returned unchanged. `measure` returns the
    measured push, and is called only where it is needed.
    """
    record = measure() if "downwash" in run.missing else None
    samples = [] if record is None else [one for one in push_samples(record) if one.exposed.any()]
    if not samples:
        return run
    downwash = np.zeros_like(run.pos)
    for one in samples:
        y = uniform_filter1d(np.where(one.exposed, one.y, 0.0), SMOOTHED)
        downwash[:, one.vehicle, 2] = np.interp(run.t, one.motion.t, y)
    return replace(run, downwash=downwash, note=NOTE)
