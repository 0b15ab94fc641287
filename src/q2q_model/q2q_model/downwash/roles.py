"""Decide by geometry who of a pair is the lower and who the upper vehicle, without a jump at dz = 0.

The envelope (15) is symmetric in the sign of dz, so which of the two laws acts must come from elsewhere:
the paper numbers its vehicles, which fails when they change places. Here, with dz = z_j - z_i,

    w(dz) = (1 + tanh(dz / b)) / 2      share of the lower vehicle's law
    gap(dz) = dz tanh(dz / b)           |dz| rounded at its corner
    eta_i = w eta_lower(dxy, gap) + (1 - w) eta_upper(dxy, gap)
"""

import numpy as np

from q2q_model.signals.values import Array

BLEND = 0.03
"""b [m]: a Crazyflie's height (29 mm, Table 1); at |dz| > 0.2 m the change is below 1e-5."""


def lower_share(dz: Array) -> Array:
    """Return w, (...,): 1 well below a source (dz > 0), 0 well above it."""
    return np.asarray(0.5 * (1.0 + np.tanh(dz / BLEND)))


def smooth_gap(dz: Array) -> Array:
    """Return the height difference [m], (...,), never below zero, without a corner at dz = 0."""
    return np.asarray(dz * np.tanh(dz / BLEND))
