"""Residual of an interaction model as a random process: turbulence under a wake.

    r = y - eta,   E r^2 = sigma^2,   sigma = floor + slope |eta|,   E r(t) r(t - h) = sigma^2 exp(-h / T)

an Ornstein-Uhlenbeck process whose size grows with the downwash, and white noise of the measurement on top.

| symbol | name | meaning [unit] |
|---|---|---|
| floor, slope | floor, slope | standard deviation without downwash [m/s^2], and its growth with |eta| [-] |
| T | time_s | correlation time [s] |
| | noise | standard deviation of the measurement of y [m/s^2] |
"""

from dataclasses import dataclass

import numpy as np

from q2q_model.signals.values import Array
from q2q_model.tunable import check_bounds, tunable

OLDEST = 0.3
"""Oldest measurement that corrects a prediction [s]: four correlation times."""


@dataclass(frozen=True, slots=True)
class ResidualProcess:
    """Size and correlation time of a model's residual."""

    floor: float = tunable(0.28, "standard deviation without downwash", unit="m/s^2", low=0, high=10)
    slope: float = tunable(0.1, "growth of the standard deviation with the downwash", low=0, high=10)
    time_s: float = tunable(0.08, "correlation time", unit="s", low=1e-3, high=10)
    noise: float = tunable(0.2, "standard deviation of the measurement", unit="m/s^2", low=1e-3, high=10)

    def __post_init__(self) -> None:
        """Check the bounds."""
        check_bounds(self)

    def std(self, eta: Array) -> Array:
        """Return sigma [m/s^2], (...,), for downwash eta [m/s^2], (...,)."""
        return np.asarray(self.floor + self.slope * np.abs(eta))

    def correlation(self, seconds: float) -> float:
        """Return the correlation of residuals so many seconds apart [-]."""
        return float(np.exp(-max(seconds, 0.0) / self.time_s))


REAL_FLIGHTS = ResidualProcess()
"""Residual under a wake of two and three Crazyflie 2.1 (flights of Neural-Swarm2, T-RO 2021)."""
