"""Previews of the reference sampled from trajectories, for controllers that look ahead."""

from collections.abc import Sequence

import numpy as np

from q2q_control.inputs.preview import SampledPreview
from q2q_model.signals.stamps import TICK_S
from q2q_model.signals.values import Names, check_unique
from q2q_model.trajectory.polynomials import Trajectory

STEP = TICK_S
"""Sampling time [s]: samples on ticks are not interpolated."""

MOST_SAMPLES = 10_000_000
"""Most samples of all vehicles: 0.7 GB, ten vehicles for 10 000 s."""

DERIVATIVES = range(3)
"""Position, velocity, acceleration."""


def sampled_preview(names: Names, trajectories: Sequence[Trajectory], start: float) -> SampledPreview:
    """Return position, velocity and acceleration of every vehicle at equal steps from `start` [s] on.

    A vehicle rests at its last point after the end of its trajectory.

    Raises:
        ValueError: a name is given twice, or the plan is too long to be kept.
    """
    check_unique(names)
    length, most = max(one.duration for one in trajectories), MOST_SAMPLES * STEP / len(names)
    if length > most:
        raise ValueError(f"plan of {length:g} s; must be at most {most:.0f} s for {len(names)} vehicles")
    times = np.asarray(np.arange(int(np.ceil(length / STEP)) + 1) * STEP, dtype=np.float64)
    samples = [[one.at(times, order)[:, :3] for order in DERIVATIVES] for one in trajectories]
    return SampledPreview(names, start, STEP, np.stack([np.concatenate(one, axis=1) for one in samples]))
