"""Errors of estimates against samples of motion capture that they have not seen.

In a degraded condition only the samples that were not given count, with all samples all of them; only those
in flight. An estimate has diverged if it restarted, is no number, or is off by more than DIVERGED although no
sample has been away for longer than SHORT within the last RECOVERY.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from q2q_model.flights.masks_over_time import last_time
from q2q_model.identification.statistics.flight_bootstrap import (
    FEWEST_FLIGHTS,
    INTERVAL_PERCENTILES,
    flight_draws,
)
from q2q_model.signals.values import Array, Mask
from q2q_sim.experiments.estimators.mocap_degradations import CONDITIONS, UNDEGRADED, given_samples
from q2q_sim.experiments.estimators.recorded_motion import RecordedMotion
from q2q_sim.experiments.estimators.replayed_estimates import RECORDED, estimates
from q2q_sim.firmware.estimator import DT

DIVERGED = 0.2
"""[m]: twice the distance at which the flight procedure refuses an estimate."""
SHORT, RECOVERY = 0.15, 0.5
"""[s]"""
BOOTSTRAP = 300
"""Draws of flights for an interval."""


@dataclass(frozen=True, slots=True)
class ReplayedErrors:
    """Errors of an estimator in the replays of one flight under one condition."""

    flight: str
    condition: str
    estimator: str
    errors: Array
    """Distances [m], all replays, (n,)."""
    replays: int
    diverged: int
    """Replays in which the estimate diverged."""


@dataclass(frozen=True, slots=True)
class ErrorSummary:
    """Errors of an estimator under one condition."""

    flights: int
    replays: int
    samples: int
    median: float
    """[m]"""
    p95: float
    """[m]"""
    worst: float
    """[m]"""
    diverged: int
    interval: tuple[float, float] | None
    """95 % interval of the median by a bootstrap over flights [m]; None below three flights."""


def replayed_errors(motion: RecordedMotion, seeds: Sequence[int]) -> Iterator[ReplayedErrors]:
    """Yield the errors of every estimator under every condition."""
    given = np.stack([given_samples(motion, one, seed) for one in CONDITIONS for seed in seeds], axis=1)
    judged = settled_ticks(given) & motion.flying[:, None]
    undegraded = np.repeat([one == UNDEGRADED for one in CONDITIONS], len(seeds))
    compared = (undegraded | ~given) & (motion.flying & motion.seen)[:, None]
    for name, found in estimates(motion, given, [*seeds] * len(CONDITIONS)).items():
        away = np.linalg.norm(found.pos - motion.pos[:, None], axis=-1)
        away[~np.isfinite(away)] = np.inf
        diverged = (judged & (away > DIVERGED)).any(axis=0) | (found.resets > 0)
        for k, condition in enumerate([UNDEGRADED] if name == RECORDED else CONDITIONS):
            own = slice(k * len(seeds), (k + 1) * len(seeds))
            errors, lost = away[:, own][compared[:, own]], int(diverged[own].sum())
            yield ReplayedErrors(motion.name, condition, name, errors, len(seeds), lost)


def settled_ticks(given: Mask) -> Mask:
    """Return the ticks (T, B) with no sample away for longer than SHORT within the last RECOVERY."""
    ticks = np.arange(len(given), dtype=np.float64)  # time in units of DT
    away = ticks[:, None] - np.maximum(last_time(given, ticks), 0.0)
    return np.asarray(ticks[:, None] - last_time(away > round(SHORT / DT), ticks) > round(RECOVERY / DT))


def summary(found: Sequence[ReplayedErrors]) -> ErrorSummary:
    """Return the errors of one estimator under one condition, over flights."""
    errors = np.concatenate([one.errors for one in found])
    median, p95 = _percentiles(errors, 50.0, 95.0)
    return ErrorSummary(
        flights=len(found),
        replays=sum(one.replays for one in found),
        samples=len(errors),
        median=float(median),
        p95=float(p95),
        worst=float(errors.max()),
        diverged=sum(one.diverged for one in found),
        interval=pooled_median_interval([one.errors for one in found]),
    )


def pooled_median_interval(flights: Sequence[Array]) -> tuple[float, float] | None:
    """Return the 95 % interval of the pooled median of flights, (m,) [m] each, by a bootstrap over flights.

    None below three flights.
    """
    if len(flights) < FEWEST_FLIGHTS:
        return None
    rows = flight_draws(len(flights), BOOTSTRAP)
    drawn = [np.median(np.concatenate([flights[k] for k in one])) for one in rows]
    low, high = _percentiles(np.array(drawn), *INTERVAL_PERCENTILES)
    return float(low), float(high)


def _percentiles(errors: Array, *shares: float) -> Array:
    """Return percentiles of errors; infinite where their neighbours are."""
    with np.errstate(invalid="ignore"):  # the difference of two infinite ones
        found = np.percentile(errors, shares)
    return np.where(np.isnan(found), np.inf, found)


def grouped(found: Sequence[ReplayedErrors]) -> Mapping[tuple[str, str], ErrorSummary]:
    """Return (condition, estimator) -> its errors over all flights, in the order of the replays."""
    keys = dict.fromkeys((one.condition, one.estimator) for one in found)
    return {key: summary([one for one in found if (one.condition, one.estimator) == key]) for key in keys}
