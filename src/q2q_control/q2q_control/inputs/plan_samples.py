"""Preview of the reference sampled from piecewise polynomials, for predictive controllers.

xi(t) = sum_k c_k (t - start of the piece)^k, as in q2q_msgs/Plan and the planner's trajectories.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from q2q_control.inputs.preview import SampledPreview
from q2q_model.signals.values import Array, Names

STEP = 0.01
"""Time between samples [s]: the 100 Hz tick, so that nothing is interpolated on ticks."""


@dataclass(frozen=True, slots=True)
class Curve:
    """Piecewise polynomial of one vehicle."""

    durations: Array
    """[s], (pieces,)."""
    coefficients: Array
    """Ascending powers, x y z first, (pieces, axes, order)."""


def sampled_preview(names: Names, curves: Sequence[Curve], start: float) -> SampledPreview:
    """Return position, velocity and acceleration of every vehicle at equal steps from `start` [s] on.

    A vehicle whose curve has ended rests at its last point.
    """
    length = max(float(curve.durations.sum()) for curve in curves)
    times = np.asarray(np.arange(int(np.ceil(length / STEP)) + 1) * STEP, dtype=np.float64)
    return SampledPreview(names, start, STEP, np.stack([_sampled(curve, times) for curve in curves]))


def _sampled(curve: Curve, times: Array) -> Array:
    """Return one vehicle's samples, (T, 9)."""
    ends = np.cumsum(curve.durations)
    clipped = np.minimum(times, ends[-1])
    piece = np.minimum(np.searchsorted(ends, clipped, side="right"), len(ends) - 1)
    tau = clipped - (ends - curve.durations)[piece]
    resting = times > ends[-1]
    columns = []
    coefficients = curve.coefficients[:, :3]  # (pieces, 3, order)
    for derivative in range(3):
        value = _horner(coefficients[piece], tau)
        columns.append(np.where(resting[:, None] & (derivative > 0), 0.0, value))
        coefficients = coefficients[..., 1:] * np.arange(1, coefficients.shape[-1])
    return np.concatenate(columns, axis=1)


def _horner(coefficients: Array, tau: Array) -> Array:
    value = np.zeros(coefficients.shape[:2])
    for k in range(coefficients.shape[-1] - 1, -1, -1):
        value = value * tau[:, None] + coefficients[..., k]
    return value
