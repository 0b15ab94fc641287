"""Noise of a recorded estimate of position and velocity: what its accelerometer does not confirm.

    S_n(f) = max(S_r(f) - S_a(f) / (2 pi f)^4, 0)     of the position r; of the velocity with (2 pi f)^2

with the spectra S_r of the estimate and S_a of the accelerometer. Motion of a vehicle shows in both, so that
the difference is noise. It is not white: a Kalman filter that is fed with positions rounded to a millimetre
leaves three times as much from 3 to 10 Hz as above 15 Hz. Below `LOWEST` errors of the accelerometer exceed
the noise; there it is taken to be as strong as in the octave above. Without an accelerometer the noise is
white, as strong as the estimate above `WHITE_FROM`, where vehicles hardly move.
"""

import numpy as np
from scipy.signal import welch

from q2q_model.signals.values import Array
from q2q_sim.experiments.validation.recorded.tracked_flight import TrackedFlight
from q2q_sim.random_streams import stream

LOWEST = 3.2
"""Lowest frequency at which noise is read [Hz]."""
WHITE_FROM = 15.0
"""Frequency above which an estimate without accelerometer counts as noise [Hz]."""
ROUNDING = 1e-3
"""Frequency below these limits that still counts [Hz]: stamps in seconds since 1970 are exact to 0.24 us."""
ROWS = 256
"""Rows of a segment of a spectrum; an even number, so that its last line is half the rate."""


def noise_density(values: Array, acc: Array, order: int, dt: float) -> tuple[Array, Array]:
    """Return frequencies [Hz], (F,), and the density of the noise of an estimate at each, (F, n, 3).

    Args:
        values: estimate, (T, n, 3).
        acc: acceleration by the accelerometer [m/s^2], NaN without one, (T, n, 3).
        order: how often `values` is to be differentiated to give it: 2 for position, 1 for velocity.
        dt: time between rows [s].
    """
    rows = min(ROWS, len(values) // 2 * 2)
    frequency, seen = welch(values, 1.0 / dt, nperseg=rows, axis=0)
    if not np.isfinite(acc).all():
        seen[-1] *= 2.0  # as of the other lines, whose negative frequencies are added
        white = seen[frequency >= WHITE_FROM - ROUNDING].mean(axis=0)  # (n, 3)
        return frequency, np.broadcast_to(white, seen.shape)
    _, moved = welch(acc, 1.0 / dt, nperseg=rows, axis=0)
    read = frequency >= LOWEST - ROUNDING
    omega = 2.0 * np.pi * frequency[read, None, None]
    density = np.empty_like(seen)
    density[read] = np.maximum(seen[read] - moved[read] / omega ** (2 * order), 0.0)
    density[~read] = density[read & (frequency < 2.0 * LOWEST)].mean(axis=0)
    return frequency, density


def colour_noise(white: Array, frequency: Array, density: Array, dt: float) -> Array:
    """Return noise of a density (F, n, 3), from white noise of unit variance (T, n, 3)."""
    at = np.fft.rfftfreq(len(white), dt)
    gain = np.sqrt(density * 0.5 / dt).reshape(len(frequency), -1)
    shape = np.stack([np.interp(at, frequency, one) for one in gain.T], axis=-1)
    drawn = np.fft.rfft(white, axis=0) * shape.reshape(-1, *white.shape[1:])
    return np.asarray(np.fft.irfft(drawn, n=len(white), axis=0))


def estimate_noise(flight: TrackedFlight, seed: int) -> tuple[Array, Array]:
    """Return a draw of the noise of position [m] and velocity [m/s], (T, n, 3) each.

    Raises:
        ValueError: the rate of the flight does not show the noise.
    """
    lowest = LOWEST if np.isfinite(flight.acc).all() else WHITE_FROM
    if 0.5 / flight.dt < lowest - ROUNDING:
        raise ValueError(
            f"flight {flight.name} cannot be flown again: the noise of its estimate is read above {lowest:g} "
            f"Hz; its rate of {1.0 / flight.dt:.4g} Hz must be at least {2.0 * lowest:g} Hz"
        )
    white = stream(seed, "estimate noise").standard_normal((2, *flight.pos.shape))
    pos, vel = (
        colour_noise(one, *noise_density(values, flight.acc, order, flight.dt), flight.dt)
        for one, values, order in ((white[0], flight.pos, 2), (white[1], flight.vel, 1))
    )
    return pos, vel
