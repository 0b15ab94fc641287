"""Smooth blend of the lower and the upper vehicle's law by the height difference of a pair.

The envelope (15) is symmetric in the sign of dz and does not select one of the two laws. The paper numbers
its vehicles, which fails when they swap places. Here, with dz = z_j - z_i,

    w(dz) = (1 + tanh(dz / b)) / 2      share of the lower vehicle's law
    gap(dz) = dz tanh(dz / b)           |dz| smoothed at zero
    eta_i = w eta_lower(dxy, gap) + (1 - w) eta_upper(dxy, gap)
"""

import numpy as np

from q2q_model.signals.values import Array

BLEND = 0.03
"""b [m]: a Crazyflie's height (29 mm, Table 1); at |dz| > 0.2 m the blend changes eta by less than 1e-5."""


def lower_share(dz: Array) -> Array:
    """Return w, (...,): 1 far below a source (dz > 0), 0 far above it."""
    return np.asarray(0.5 * (1.0 + np.tanh(dz / BLEND)))


def smooth_gap(dz: Array) -> Array:
    """Return the height difference [m], (...,), never negative and smooth at dz = 0."""
    return np.asarray(dz * np.tanh(dz / BLEND))
