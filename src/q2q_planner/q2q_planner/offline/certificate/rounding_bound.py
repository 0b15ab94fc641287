"""A-priori bound of the rounding in a certificate, and in the setpoints that are flown.

A piece with coefficients c_k and length T is computed with errors in proportion to its coefficients, not to
its positions, which are small where the coefficients cancel (Higham, Accuracy and Stability of Numerical
Algorithms, 2nd ed., 2002, sections 3.1 and 5.1). With

    A = max sum_k |c_k| T^k,   V = max sum_k k |c_k| T^(k - 1)   over vehicles, pieces and axes,

every position that passes through n roundings is off by at most gamma_n A an axis, gamma_n = n u / (1 - n u),
and by at most V dt for a time that is off by dt. The difference of two positions in three axes is off by

    2 sqrt(3) (gamma_n A + V (gamma_8 T_end + delta) + J)

where delta is the largest difference of ends that count as the same time, and J, if delta > 0, the largest
jump of a position between two pieces. Roundings of m coefficients: shifted to a cut m + 4, to Bernstein's
basis m + 4, difference 1, DEEPEST halvings of m + 1 each, distance to the zone 20, Horner's scheme of the
player 2 m.

Not bounded, hence infinite: a piece shorter than SHORTEST, which the cuts may miss; more coefficients than
MOST_COEFFICIENTS, whose binomials are rounded; sums that overflow.
"""

from collections.abc import Sequence

import numpy as np

from q2q_model.trajectory.polynomials import Trajectory
from q2q_planner.offline.certificate.reference_steps import largest_steps
from q2q_planner.offline.certificate.shared_pieces import SAME_TIME, common_cuts

UNIT_ROUNDOFF = 2.0**-53
"""u of a double."""

DEEPEST = 40
"""Most halvings of a piece: 1e-12 of its length."""

SHORTEST = 1e-6
"""Shortest piece [s]: a thousand times SAME_TIME, a thousandth of the shortest piece that is planned."""

MOST_COEFFICIENTS = 56
"""Beyond, C(m - 1, k) is not a double."""

ROUNDING = 1e-9
"""Minimum slack for rounding [m]: 1e5 times the last bit of a position of 50 m."""

MOST_ROUNDING = 1.0
"""Rounding beyond which nothing is computed, so that nothing overflows [m]."""

NOT_BOUNDED = (
    f"positions may be rounded by more than {MOST_ROUNDING:g} m: coefficients are too large or too many, or "
    f"a piece is shorter than {SHORTEST:g} s"
)
"""Why nothing is proven of such a plan."""

UNDERFLOW = 1e-200
"""What products below the normal numbers are off by [m]: 5e-324 for each, times powers of a duration."""


def rounding_slack(trajectories: Sequence[Trajectory]) -> float:
    """Return what a proof takes off for rounding [m]: the bound, at least ROUNDING."""
    return max(ROUNDING, rounding_bound(trajectories))


def rounding_bound(trajectories: Sequence[Trajectory]) -> float:
    """Return a bound of the error of every computed relative position [m]; infinite where there is none."""
    order = max(curve.coefficients.shape[-1] for curve in trajectories)
    if order > MOST_COEFFICIENTS or min(curve.durations.min() for curve in trajectories) < SHORTEST:
        return np.inf
    with np.errstate(over="ignore", invalid="ignore"):
        reach = max(_majorant(curve, 0) for curve in trajectories)
        speed = max(_majorant(curve, 1) for curve in trajectories)
        apart = _merged_by(trajectories)
        jump = max(largest_steps(curve).pos for curve in trajectories) if apart > 0.0 else 0.0
        off = _gamma(8) * max(curve.duration for curve in trajectories) + apart
        bound = 2.0 * np.sqrt(3.0) * (_gamma(_roundings(order)) * reach + speed * off + jump) + UNDERFLOW
    return float(bound) if np.isfinite(bound) and apart <= SAME_TIME else np.inf


def _roundings(order: int) -> int:
    return 2 * (order + 4) + 1 + DEEPEST * (order + 1) + 20 + 2 * order


def _gamma(count: int) -> float:
    return count * UNIT_ROUNDOFF / (1.0 - count * UNIT_ROUNDOFF)


def _majorant(curve: Trajectory, derivative: int) -> float:
    """Return the largest sum_k |c_k| T^k of a position, or sum_k k |c_k| T^(k - 1)."""
    size = np.abs(curve.coefficients[:, :3])
    power = np.arange(size.shape[-1])
    factor = power**derivative * curve.durations[:, None] ** np.maximum(power - derivative, 0)
    return float((size * factor[:, None, :]).sum(-1).max())


def _merged_by(trajectories: Sequence[Trajectory]) -> float:
    """Return the largest time from a common cut to the end of a piece that counts as the same [s]."""
    cuts = common_cuts(trajectories)
    ends = np.concatenate([np.cumsum(curve.durations) for curve in trajectories])
    return float((ends - cuts[np.searchsorted(cuts, ends, side="right") - 1]).max())
