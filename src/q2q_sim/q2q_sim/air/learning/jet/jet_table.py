"""Table of a jet from its splines: measured between the lowest and the highest gap flown, continued beyond.

Above, a free round jet goes on with constant momentum (Rajaratnam, Turbulent Jets, 1976):

    P(gap, r) = q^2 P(g, q r),   q = (g + z0) / (gap + z0)      g: highest gap flown, z0: virtual origin

with z0 from the decay on the axis just above g. Below the lowest gap flown P is that of the lowest.

A jet carries the momentum flux m g of its source. If rotor disks of area A take all that meets them, the
integral of m P over the plane is A m g at each gap, whatever the shape of the jet:

    share of momentum(gap) = 1 / (A g) * integral of P 2 pi r dr
"""

import numpy as np
from scipy.interpolate import RegularGridInterpolator

from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import GRAVITY, ROTOR_RADIUS
from q2q_sim.air.air_terms import JetTerm
from q2q_sim.air.learning.jet.jet_splines import spline_values

GAPS = np.concatenate([np.arange(0.0, 0.975, 0.05), np.arange(1.0, 2.05, 0.1)]).round(3)
"""Gaps of a table [m]."""
RADII = np.concatenate([np.arange(0.0, 0.31, 0.02), np.arange(0.35, 0.91, 0.05)]).round(3)
"""Radii of a table [m]: the splines' reach, and what a free jet becomes at the last gap."""
DECIMALS = 4
"""Decimals of a table: 0.1 mm/s^2."""
ORIGIN = (0.05, 1.0)
"""Bounds of the virtual origin [m]: a rotor's diameter, the height of the flights."""
NEARBY = 0.1
"""Height over which the decay on the axis is taken [m]."""


def push_table(beta: Array, flown: tuple[float, float]) -> Array:
    """Return P [m/s^2] on the grid of GAPS and RADII, (gaps, radii).

    Args:
        beta: coefficients of the splines, (p,).
        flown: lowest and highest gap flown [m].
    """
    low, high = flown
    origin = _origin(beta, high)
    gap, radius = (axis.ravel() for axis in np.meshgrid(GAPS, RADII, indexing="ij"))
    thinner = np.minimum((high + origin) / (gap + origin), 1.0)
    found = thinner**2 * (spline_values(np.clip(gap, low, high), thinner * radius) @ beta)
    return np.asarray(found.reshape(GAPS.size, RADII.size).round(DECIMALS))


def _origin(beta: Array, high: float) -> float:
    """Return z0 of P ~ (gap + z0)^-2 on the axis below `high` [m]."""
    above, below = spline_values(np.array([high - NEARBY, high]), np.zeros(2)) @ beta
    if below <= 0.0 or above <= below:
        return ORIGIN[1]
    ratio = float(np.sqrt(above / below))  # (high + z0) / (high - NEARBY + z0)
    return float(np.clip(NEARBY * ratio / (ratio - 1.0) - high, *ORIGIN))


def push_in_table(term: JetTerm, gap: Array, radius: Array) -> Array:
    """Return P [m/s^2] at places (k,), by linear interpolation; 0 outside the table."""
    table = RegularGridInterpolator(
        (term.gaps_m, term.radii_m), term.push_mps2, bounds_error=False, fill_value=0.0
    )
    return np.asarray(table(np.stack([gap, radius], axis=-1)))


def momentum_share(term: JetTerm, gap: float) -> float:
    """Return the share of its source's momentum that a jet gives at a gap [m] to disks of four rotors."""
    at = push_in_table(term, np.full(term.radii_m.size, gap), term.radii_m)
    disk = 4.0 * np.pi * ROTOR_RADIUS**2
    return float(np.trapezoid(2.0 * np.pi * term.radii_m * at, term.radii_m) / (disk * GRAVITY))
