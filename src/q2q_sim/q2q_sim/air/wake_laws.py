"""True downwash of the simulated air. Never a model under test: no block under test reads it.

A source j at dz = z_j - z_i above i, dxy beside it, pushes i down by P(dz, dxy) >= 0 [m/s^2] and feels a
fraction u of it upwards. With s(dz) the width of the downwash:

paper (no delay; constants of q2q_model.downwash.jet.PAPER_LAW):
    P = A ((z0 + dz_ref) / (z0 + dz))^2 exp(-dxy^2 / 2 s^2),  s = s0 + ks dz
measured (two real Crazyflies 2.1, feed-forward off; constants of MEASURED_LAW next to it, except ks):
    P = A exp(-beta (dz - dz_ref)) exp(-dxy^2 / 2 s^2) T_j / (m g),  s = s0 + ks (dz - dz_ref)
    it travels down at the speed c: r_j and T_j are those at time t - tau, tau = dz / c
    A, beta and s0 are from the three-parameter fit; on the same flights (dc19) the R2 of the
    vertical acceleration is .853 without delay, .865 with it, .866 if the width also grows by .03, and lower
    with more growth; u: the upper vehicles' mean is -.01 and +.05 m/s^2, never above 2 % of g.
none: P = 0.

Both are accelerations between vehicles of equal weight. The law is the same for every vehicle type and
lengths are not scaled (the paper does the same when it flies 0.65 kg with downwash learned at 34 g). All
vehicles of a swarm are of one type. Where the pair changes roles, |dz| < b, the two parts are blended by a
cubic, so that eta is smooth.

| symbol | name | meaning [unit] |
|---|---|---|
| P | push | acceleration of the lower vehicle, downwards [m/s^2] |
| s | width | standard deviation of the downwash profile [m] |
| u | UPPER | fraction that the upper vehicle feels, upwards [-] |
| tau | delay | transport delay [s] |
| b | BLEND | half height of the change of roles [m] |
"""

import math
from enum import IntEnum

from q2q_model.compiled import compiled
from q2q_model.downwash.jet import MEASURED_LAW, PAPER_LAW


class WakeLaw(IntEnum):
    """Kinds of true downwash."""

    NONE = 0
    PAPER = 1
    MEASURED = 2


NONE, PAPER, MEASURED = int(WakeLaw.NONE), int(WakeLaw.PAPER), int(WakeLaw.MEASURED)
"""Kinds in compiled code."""


PAPER_A, PAPER_DZ, PAPER_Z0 = PAPER_LAW.strength, PAPER_LAW.reference_gap, PAPER_LAW.virtual_origin
"""[m/s^2], [m], [m]."""
PAPER_S0, PAPER_KS, PAPER_UPPER = PAPER_LAW.width, PAPER_LAW.spread, PAPER_LAW.upper_ratio
"""[m], [m/m], [-]."""
MEASURED_A, MEASURED_DZ, MEASURED_BETA = (
    MEASURED_LAW.strength,
    MEASURED_LAW.reference_gap,
    MEASURED_LAW.decay_rate,
)
"""[m/s^2], [m], [1/m]."""
MEASURED_S, MEASURED_UPPER, MEASURED_SPEED = (
    MEASURED_LAW.width,
    MEASURED_LAW.upper_ratio,
    MEASURED_LAW.travel_speed,
)
"""[m], [-], [m/s]: lag 25 ms at dz 0.15 m to over 110 ms at 0.8 m."""
MEASURED_KS = 0.03
"""Growth of the width [m/m]; the model's law has none."""
NARROWEST = 0.02
"""Smallest width [m]; reached only where vehicles touch."""
MAX_DELAY = 0.4
"""Longest delay kept [s]: 3 m of travel, where P has fallen to 8 %."""
BLEND = 0.1
"""b [m]: no two vehicles fly closer than about 0.1 m."""
EDGE = 6.0
"""Distance in widths beyond which P is zero: there it is 1.5e-8 of its peak [-]."""
FASTEST = 3.0
"""Largest speed of a source whose past position is searched [m/s]."""


def wake_by_name(name: str) -> WakeLaw:
    """Return the named wake; raise ValueError with the known names."""
    known = {wake.name.lower(): wake for wake in WakeLaw}
    if name not in known:
        raise ValueError(f"unknown wake {name!r}; choose one of {', '.join(known)}")
    return known[name]


def max_delay(kind: WakeLaw) -> float:
    """Return the longest delay of the downwash [s]."""
    return MAX_DELAY if kind == WakeLaw.MEASURED else 0.0


@compiled
def wake_width(kind: int, gap: float) -> float:
    """Return s [m] at |dz| = gap [m]."""
    if kind == PAPER:
        return PAPER_S0 + PAPER_KS * gap
    return max(MEASURED_S + MEASURED_KS * (gap - MEASURED_DZ), NARROWEST)


@compiled
def wake_push(kind: int, gap: float, dxy_squared: float) -> float:
    """Return P [m/s^2] at |dz| = gap [m] and a squared horizontal distance [m^2]."""
    s = wake_width(kind, gap)
    if dxy_squared > (EDGE * s) ** 2:
        return 0.0
    profile = math.exp(-dxy_squared / (2.0 * s * s))
    if kind == PAPER:
        return PAPER_A * ((PAPER_Z0 + PAPER_DZ) / (PAPER_Z0 + gap)) ** 2 * profile
    return MEASURED_A * math.exp(-MEASURED_BETA * (gap - MEASURED_DZ)) * profile


@compiled
def pair_eta(kind: int, dxy_squared: float, dz: float) -> tuple[float, float]:
    """Return the vertical acceleration [m/s^2] of i by j and of j by i, at dz = z_j - z_i [m].

    `dxy_squared` is their squared horizontal distance [m^2].
    """
    strength = wake_push(kind, abs(dz), dxy_squared)
    upper = PAPER_UPPER if kind == PAPER else MEASURED_UPPER
    along = min(max(0.5 * (dz / BLEND + 1.0), 0.0), 1.0)
    share = along * along * (3.0 - 2.0 * along)  # weight of the lower vehicle's part, for i
    return strength * ((1.0 - share) * upper - share), strength * (share * upper - (1.0 - share))


@compiled
def wake_delay(kind: int, dz: float) -> float:
    """Return the delay of the downwash from a source at height difference dz [m], [s]; 0 upwards."""
    if kind != MEASURED or dz <= 0.0:
        return 0.0
    return min(dz / MEASURED_SPEED, MAX_DELAY)


@compiled
def wake_reach(kind: int, gap: float) -> float:
    """Return the largest horizontal distance at which a source at |dz| = gap acts on a vehicle [m]."""
    return float(EDGE * wake_width(kind, gap) + FASTEST * wake_delay(kind, gap))
