"""Bootstrap over flights (Efron, Tibshirani, An introduction to the bootstrap, 1993)."""

import numpy as np

from q2q_model.signals.values import Rows

FEWEST_FLIGHTS = 3
"""Flights from which an interval is given: two parameters fit two exactly, whatever these measured."""
INTERVAL_PERCENTILES = (2.5, 97.5)
"""Percentiles of the draws at the ends of a 95 % interval."""


def flight_draws(flights: int, draws: int, seed: int = 0) -> Rows:
    """Return draws of flights with replacement, a row of numbers from 0 each, (draws, flights)."""
    return np.random.default_rng(seed).integers(0, flights, (draws, flights))
