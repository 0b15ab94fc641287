"""Power of a height error in octave bands from 0.2 to 10 Hz, by Welch's method.

Segments of 5.12 s with a Hann window overlap by half (Welch, 1967). A segment is under a wake if a tenth of
its rows is, so that passes count with what they leave behind, and in clear air if 95 % of its rows are.
"""

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from scipy.signal import spectrogram

from q2q_model.signals.values import Array, Mask

EDGES = np.array([0.19, 0.4, 0.8, 1.6, 3.2, 6.4, 10.0])
"""Limits of the bands [Hz]; the first lies below the first line, 0.195 Hz."""
SEGMENT = 5.12
"""Length of a segment [s]: the period of the slowest line, a power of two of rows at 100 Hz."""
EXPOSED_SHARE = 0.1
"""Share of rows under a wake from which a segment is [-]."""
CLEAR_SHARE = 0.95
"""Share of rows in clear air from which a segment is [-]: short gaps are allowed."""


def band_power(error: Array, dt: float) -> Array:
    """Return the power in each band [m^2] of each segment of errors (..., T), (..., segments, bands)."""
    rows = segment_rows(dt)
    frequency, _, density = spectrogram(
        error, 1.0 / dt, window="hann", nperseg=rows, noverlap=rows // 2, detrend="constant"
    )
    band = np.searchsorted(EDGES, frequency) - 1
    lines = np.stack([band == k for k in range(len(EDGES) - 1)])  # (bands, lines)
    return np.asarray(np.moveaxis(density, -1, -2) @ lines.T / (rows * dt))


def segment_share(rows: Mask, dt: float) -> Array:
    """Return the share of each segment (segments,) that lies in `rows` (T,)."""
    length = segment_rows(dt)
    if len(rows) < length:
        return np.zeros(0)
    return np.asarray(sliding_window_view(rows, length)[:: length - length // 2].mean(axis=-1))


def segment_rows(dt: float) -> int:
    """Return the rows of a segment."""
    return round(SEGMENT / dt)
