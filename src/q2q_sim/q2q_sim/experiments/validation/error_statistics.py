"""Numbers that compare simulated with recorded height errors e = z - z_ref on the same rows.

| number | definition |
|---|---|
| z_rms_ratio | rms of all simulated errors over the rms of the recorded one |
| correlation | of the mean simulated error with the recorded one, all rows together |
| spectrum_db | largest |10 lg (simulated / recorded power)| over octave bands from 0.2 to 10 Hz |
| coverage95 | share of recorded samples in the band that holds 95 % of a further draw |
| worst_ratio | mean over draws of the worst |e| over the worst recorded one |

The band at each row is mean +- t s sqrt(1 + 1/D) of the D draws, with Student's t: the prediction interval of
a normal. Sums over rows are kept, so that flights are pooled by adding.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce

import numpy as np
from scipy.special import stdtrit

from q2q_model.identification.statistics.flight_bootstrap import (
    FEWEST_FLIGHTS,
    INTERVAL_PERCENTILES,
    flight_draws,
)
from q2q_model.signals.values import Array, Mask
from q2q_sim.experiments.validation.error_spectrum import EDGES, band_power, segment_share

BOOTSTRAP = 1000
"""Draws of flights for an interval."""


@dataclass(frozen=True, slots=True)
class ErrorSums:
    """Sums over compared rows; r: recorded error, s: simulated one, m: its mean over draws."""

    n: int
    r: float
    """[m]"""
    m: float
    rr: float
    """[m^2]"""
    mm: float
    rm: float
    ss: float
    """Mean over draws [m^2]."""
    inside: int
    """Recorded samples inside the band."""
    worst: float
    """Largest |r| [m]."""
    worst_drawn: Array
    """Largest |s| of each draw [m], (draws,)."""
    power: Array
    """Recorded power in each band, summed over segments [m^2], (bands,)."""
    power_drawn: Array
    """Simulated power, mean over draws [m^2], (bands,)."""
    segments: int
    """Segments of the sums of power."""

    def __add__(self, other: "ErrorSums") -> "ErrorSums":
        """Return the sums over the rows of both."""
        return ErrorSums(
            n=self.n + other.n,
            r=self.r + other.r,
            m=self.m + other.m,
            rr=self.rr + other.rr,
            mm=self.mm + other.mm,
            rm=self.rm + other.rm,
            ss=self.ss + other.ss,
            inside=self.inside + other.inside,
            worst=float(np.maximum(self.worst, other.worst)),
            worst_drawn=np.maximum(self.worst_drawn, other.worst_drawn),
            power=self.power + other.power,
            power_drawn=self.power_drawn + other.power_drawn,
            segments=self.segments + other.segments,
        )


@dataclass(frozen=True, slots=True)
class Comparison:
    """Numbers of the table above; None without rows, or without a segment for the spectrum."""

    z_rms_ratio: float | None
    correlation: float | None
    spectrum_db: float | None
    coverage95: float | None
    worst_ratio: float | None
    n: int
    """Compared rows."""
    z_rms_recorded_m: float | None = None


NOTHING = Comparison(None, None, None, None, None, 0)


def error_sums(recorded: Array, drawn: Array, rows: Mask, dt: float, share: float) -> ErrorSums:
    """Return the sums of one vehicle.

    Args:
        recorded: e [m], (T,).
        drawn: e of each draw [m], (draws, T).
        rows: rows that are compared, (T,).
        dt: time between rows [s].
        share: share of `rows` in a segment from which its spectrum is compared.
    """
    draws = len(drawn)
    mean, std = drawn.mean(axis=0)[rows], drawn.std(axis=0, ddof=1)[rows]
    half = stdtrit(draws - 1, 0.975) * std * np.sqrt(1.0 + 1.0 / draws)
    r, s = recorded[rows], drawn[:, rows]
    segments = segment_share(rows, dt) >= share
    power = [np.zeros(len(EDGES) - 1)] * 2
    if segments.any():
        power = [band_power(recorded, dt)[segments], band_power(drawn, dt)[:, segments].mean(axis=0)]
        power = [one.sum(axis=0) for one in power]
    return ErrorSums(
        n=int(rows.sum()),
        r=float(r.sum()),
        m=float(mean.sum()),
        rr=float(r @ r),
        mm=float(mean @ mean),
        rm=float(r @ mean),
        ss=float((s**2).sum() / draws),
        inside=int((np.abs(r - mean) <= half).sum()),
        worst=float(np.abs(r).max(initial=0.0)),
        worst_drawn=np.abs(s).max(axis=1, initial=0.0),
        power=power[0],
        power_drawn=power[1],
        segments=int(segments.sum()),
    )


def comparison(parts: Sequence[ErrorSums]) -> Comparison:
    """Return the numbers over the rows of all parts."""
    whole = reduce(ErrorSums.__add__, parts) if parts else None
    if whole is None or whole.n == 0:
        return NOTHING
    n = whole.n
    spread = (whole.rr - whole.r**2 / n) * (whole.mm - whole.m**2 / n)
    bands = whole.power > 0.0
    decibel = 10.0 * np.log10(whole.power_drawn[bands] / whole.power[bands])
    return Comparison(
        z_rms_ratio=float(np.sqrt(whole.ss / whole.rr)),
        correlation=float((whole.rm - whole.r * whole.m / n) / np.sqrt(spread)) if spread > 0.0 else None,
        spectrum_db=float(np.abs(decibel).max()) if bands.any() else None,
        coverage95=whole.inside / n,
        worst_ratio=float(whole.worst_drawn.mean() / whole.worst),
        n=n,
        z_rms_recorded_m=float(np.sqrt(whole.rr / n)),
    )


def flight_intervals(flights: Sequence[Sequence[ErrorSums]]) -> dict[str, tuple[float, float]]:
    """Return the 95 % interval of each pooled number by a bootstrap over flights; empty below 3 flights."""
    flown = [reduce(ErrorSums.__add__, parts) for parts in flights if sum(part.n for part in parts)]
    if len(flown) < FEWEST_FLIGHTS:
        return {}
    drawn = [comparison([flown[k] for k in rows]) for rows in flight_draws(len(flown), BOOTSTRAP)]
    found = {}
    for name in ("z_rms_ratio", "correlation", "spectrum_db", "coverage95", "worst_ratio"):
        values = [value for one in drawn if (value := getattr(one, name)) is not None]
        if values:
            low, high = np.percentile(values, INTERVAL_PERCENTILES)
            found[name] = float(low), float(high)
    return found
