"""Check of recorded angular rates against the change of attitude.

Over SPAN_S, a vehicle turns by the rotation vector of q(t)^-1 q(t + SPAN_S), which the mean of its rates
explains. With a, the turns over time about body x and y, and w, the mean rates, both less their means, two
regression lines enclose the slope of the rates:

    sum a w / sum a^2 <= slope <= sum w^2 / sum a w

Recorded Crazyflies have slopes of 0.97 to 1.0. Another sign shows axes, or a conjugated attitude; a slope of
57, degrees per second.
"""

from collections.abc import Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from q2q_model.flights.flight import Flight
from q2q_model.signals.values import Array

SPAN_S = 0.06
"""Time of a turn [s], over which noise of 1 mrad is 0.02 rad/s."""
LONGEST_STEP = 0.02
"""Longest step of a flight that is checked [s]: in slower ones, attitudes turn too far between rows."""
LARGEST_TURN = 0.6
"""Largest turn over SPAN_S [rad], up to which the mean of rates is the turn over time."""
LEAST_RATE = 0.05
"""Minimum rms rate about x and y of a vehicle that is checked [rad/s]."""
FEWEST_ROWS = 200
"""Fewest rows: 2 s at 100 Hz."""
ALIKE = 0.5
"""Minimum magnitude of the correlation: beneath it, noise hides the slope."""
SLOPES = (0.7, 1.3)
"""Bounds of the slope [-]."""


def rate_notes(flights: Sequence[Flight]) -> list[str]:
    """Return a note if angular rates contradict attitudes."""
    found = [
        slopes
        for flight in flights
        for i in range(len(flight.names))
        if (slopes := _slopes(flight.t, _attitude(flight, i), flight.gyro_body[:, i])) is not None
    ]
    wrong = [(low, high) for low, high in found if high < SLOPES[0] or low > SLOPES[1]]
    if not wrong:
        return []
    low, high = np.median(np.array(wrong), axis=0)
    return [
        (
            f"angular rates are {low:.2f} to {high:.2f} times the change of attitude for {len(wrong)} of "
            f"{len(found)} vehicles of flights, expected {SLOPES[0]:g} to {SLOPES[1]:g}: check that rates "
            "are in rad/s about body axes, and that attitudes are x y z w, body to world"
        )
    ]


def _attitude(flight: Flight, i: int) -> Array:
    """Return the measured attitude of a vehicle, else the estimated one, (T, 4)."""
    measured = flight.mocap_quat[:, i]
    return measured if np.isfinite(measured).any() else flight.quat[:, i]


def _slopes(t: Array, quat: Array, rate: Array) -> tuple[float, float] | None:
    """Return the slopes of both lines; None of a vehicle that does not turn, or is not measured enough."""
    step = float(np.median(np.diff(t))) if t.size > 1 else np.inf
    span = round(SPAN_S / step) if 0.0 < step <= LONGEST_STEP else t.size
    if t.size <= span:
        return None
    norm = np.linalg.norm(quat, axis=1)
    known = (norm > 0.5) & (norm < 2.0)
    turns = Rotation.from_quat(np.where(known[:, None], quat, (0.0, 0.0, 0.0, 1.0)))
    lasts = (t[span:] - t[:-span])[:, None]
    turn = (turns[:-span].inv() * turns[span:]).as_rotvec()
    turned = turn[:, :2] / lasts
    steps = 0.5 * (rate[1:, :2] + rate[:-1, :2]) * np.diff(t)[:, None]
    mean = np.lib.stride_tricks.sliding_window_view(steps, span, axis=0).sum(axis=-1) / lasts
    rows = known[span:] & known[:-span] & np.isfinite(mean).all(axis=1)
    rows &= (lasts[:, 0] < 2.0 * SPAN_S) & (np.linalg.norm(turn, axis=1) < LARGEST_TURN)
    if rows.sum() < FEWEST_ROWS:
        return None
    a, w = (one[rows] - one[rows].mean(axis=0) for one in (turned, mean))
    along, squares = float(np.sum(a * w)), (float(np.sum(a * a)), float(np.sum(w * w)))
    if min(squares) < rows.sum() * LEAST_RATE**2 or abs(along) < ALIKE * np.sqrt(squares[0] * squares[1]):
        return None
    low, high = sorted((along / squares[0], squares[1] / along))
    return low, high
