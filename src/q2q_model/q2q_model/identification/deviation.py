"""Altitude deviation of vehicles flying above each other, and the zone height d derived from it (3.1).

    dev = mean over T_eps of |z_1,ref - z_1| + |z_2,ref - z_2|,    T_eps = { t : dxy(t) <= eps, steady }
    dev(dz_av) = alpha exp(-beta |dz_av|),   d: where that has fallen to `allowed`

Interpretation: the sum is over both absolute values. Each vehicle's median deviation in clear air, 15 to 40
mm on real flights, is subtracted first. Intervals come from a bootstrap over flights (Efron, Tibshirani, An
introduction to the bootstrap, 1993). dev depends on the time of overlap more than on distance, so d is a
rough value; the level set of the learned downwash is the alternative.

| symbol | name | meaning [unit] |
|---|---|---|
| eps | eps | horizontal distance that counts as overlap [m] |
| alpha, beta | alpha, beta | dev at dz = 0 [m] and its decay rate [1/m] |
| d | d | half height of the zone [m] |
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from operator import attrgetter

import numpy as np

from q2q_model.geometry.zone import Cylinder
from q2q_model.identification.gains.altitude_record import AltitudeRecord, in_clear_air
from q2q_model.identification.gains.impulse_response import CLEAR
from q2q_model.identification.statistics.flight_bootstrap import (
    FEWEST_FLIGHTS,
    INTERVAL_PERCENTILES,
    flight_draws,
)
from q2q_model.identification.statistics.intervals import UNKNOWN, Interval
from q2q_model.signals.values import Array

DRAWS = 500
"""Bootstrap draws: ends of a 95 % interval to a few percent of its width."""
FEWEST_ROWS = 5
"""Fewest rows of overlap for a mean: 50 ms at 100 Hz."""
RATES = np.linspace(-2.0, 10.0, 601)
"""Grid of beta [1/m], much finer than any confidence interval."""
FARTHEST = 10.0
"""d of a deviation that does not decay [m]: above the height of any flight room; d is unknown then."""
ALIKE = 0.1
"""Difference of the largest and the smallest gap below which they show no decay [m]: a vehicle's size."""
_UNBOUNDED = np.array([[0.0, RATES[0], 0.0], [UNKNOWN, RATES[-1], FARTHEST]])
"""Ends of the intervals of alpha, beta and d that nothing is known of, (2, 3)."""


@dataclass(frozen=True, slots=True)
class DeviationParams:
    """Choices of section 3.1."""

    eps: float = Cylinder().eps
    """Horizontal distance [m]: that of the zone."""
    steady: float = 15.0
    """Initial time that is ignored [s]; section 3.1."""
    clear: float = CLEAR
    """Horizontal distance beyond which a vehicle is in clear air [m]."""
    allowed: float = 0.02
    """Acceptable deviation [m]: a fifth of eps."""
    seed: int = 0


@dataclass(frozen=True, slots=True)
class Overlap:
    """Mean deviation of one flight during overlap."""

    flight: str
    gap: float
    """|dz_av| [m]."""
    dev: float
    """[m]"""
    seconds: float


@dataclass(frozen=True, slots=True)
class DecayFit:
    """Fitted decay and the resulting half height."""

    overlaps: tuple[Overlap, ...]
    alpha: Interval
    beta: Interval
    d: Interval
    extrapolated: bool
    """Whether d is beyond the largest average gap of a flight."""


def overlap_of(record: AltitudeRecord, params: DeviationParams) -> Overlap | None:
    """Return dev and gap of the pair of a flight that overlaps longest; None without overlap."""
    late = record.t - record.t[0] >= min(params.steady, 0.5 * (record.t[-1] - record.t[0]))
    away = np.abs(record.deviation - _clear_bias(record, params.clear))
    found = []
    for i, j in combinations(range(len(record.names)), 2):
        rel = record.pos[:, j] - record.pos[:, i]
        rows = late & (np.hypot(rel[:, 0], rel[:, 1]) <= params.eps)
        if (count := int(rows.sum())) >= FEWEST_ROWS:
            gap, dev = float(np.abs(rel[rows, 2].mean())), float((away[rows, i] + away[rows, j]).mean())
            found.append(Overlap(record.name, gap, dev, count * record.dt))
    return max(found, key=attrgetter("seconds"), default=None)


def overlaps_of(
    records: Sequence[AltitudeRecord], params: DeviationParams | None = None
) -> tuple[Overlap, ...]:
    """Return the overlap of each flight that has one, over all its records."""
    given = params or DeviationParams()
    pieces: dict[str, list[Overlap]] = {}
    for record in records:
        if (one := overlap_of(record, given)) is not None:
            pieces.setdefault(record.name, []).append(one)
    return tuple(_joined(one) for one in pieces.values())


def _joined(pieces: Sequence[Overlap]) -> Overlap:
    seconds = np.array([one.seconds for one in pieces])
    gap, dev = (np.average([(one.gap, one.dev) for one in pieces], axis=0, weights=seconds)).tolist()
    return Overlap(pieces[0].flight, gap, dev, float(seconds.sum()))


def fit_decay(records: Sequence[AltitudeRecord], params: DeviationParams | None = None) -> DecayFit:
    """Return the decay of dev with the gap, and d.

    Raises:
        ValueError: fewer than two flights have overlap, or dev does not fall to `allowed` with the gap.
    """
    given = params or DeviationParams()
    overlaps = overlaps_of(records, given)
    if len(overlaps) < 2:
        raise ValueError(
            f"{len(overlaps)} of {len({one.name for one in records})} flights have vehicles within "
            f"{given.eps} m of each other horizontally; the decay of dev needs at least 2"
        )
    gaps, devs = np.array([o.gap for o in overlaps]), np.array([o.dev for o in overlaps])
    best = _decay(gaps, devs, given.allowed)
    if best[-1] >= FARTHEST:
        raise ValueError(_no_decay(gaps, devs, given.allowed))
    low, high = _bootstrap(gaps, devs, given) if gaps.size >= FEWEST_FLIGHTS else _UNBOUNDED
    alpha, beta, d = (
        Interval(float(v), float(min(a, v)), float(max(b, v)))
        for v, a, b in zip(best, low, high, strict=True)
    )
    return DecayFit(overlaps, alpha, beta, d, extrapolated=bool(d.value > gaps.max()))


def _no_decay(gaps: Array, devs: Array, allowed: float) -> str:
    """Return why flights show no d: their gaps are alike, or dev does not fall with them."""
    reason = f"dev does not fall with the gap to {allowed} m within {FARTHEST:g} m"
    if np.ptp(gaps) < ALIKE:
        reason = "the gaps flown are too alike to show how dev falls with the gap"
    flown = ", ".join(f"{dev:.3f} m at {gap:.2f} m" for gap, dev in sorted(zip(gaps, devs, strict=True)))
    return f"{reason} ({flown}): fly passes alike in speed and duration, at gaps further apart"


def _bootstrap(gaps: Array, devs: Array, params: DeviationParams) -> Array:
    """Return the ends of the intervals of alpha, beta and d by a bootstrap over flights, (2, 3).

    Draws whose gaps lie too close to each other for a decay are left out.
    """
    drawn = flight_draws(gaps.size, DRAWS, params.seed)
    apart = np.ptp(gaps[drawn], axis=1) > 0.1 * np.ptp(gaps)
    taken = drawn[apart] if apart.any() else np.arange(gaps.size)[None]
    draws = [_decay(gaps[rows], devs[rows], params.allowed) for rows in taken]
    return np.asarray(np.percentile(np.array(draws), INTERVAL_PERCENTILES, axis=0))


def _decay(gaps: Array, devs: Array, allowed: float) -> tuple[float, float, float]:
    """Return alpha, beta and d of the least-squares fit alpha exp(-beta gap), over a grid of beta.

    d is 0 of a fit that is within `allowed` at every gap flown, and FARTHEST of another that does not decay.
    """
    shape = np.exp(-RATES[:, None] * gaps)
    alphas = (shape @ devs) / (shape * shape).sum(axis=1)
    best = int(np.argmin(((alphas[:, None] * shape - devs) ** 2).sum(axis=1)))
    alpha, beta = float(alphas[best]), float(RATES[best])
    largest = alpha * max(1.0, float(np.exp(-beta * gaps.max())))  # at a gap of 0, or the largest flown
    if largest <= allowed:
        return alpha, beta, 0.0
    d = float(np.log(alpha / allowed)) / beta if beta > 0.0 else FARTHEST
    return alpha, beta, min(d, FARTHEST)


def _clear_bias(record: AltitudeRecord, clear: float) -> Array:
    """Return every vehicle's median deviation in clear air [m], (n,); 0 if it has too few rows there."""
    n, alone = len(record.names), in_clear_air(record, clear)
    bias = np.zeros(n)
    for i in range(n):
        if alone[:, i].sum() >= FEWEST_ROWS:
            bias[i] = np.median(record.deviation[alone[:, i], i])
    return bias
