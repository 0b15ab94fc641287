"""Measured downwash, the vertical acceleration not due to thrust, and scores of models on it.

    y_i = (a_z + g) - T_i b_z / m          T: thrust of the rotors, b: body z

minus its median over free rows, a constant of each vehicle (battery, mass, sensor). The rules for scoring the
recorded flights of two and three Crazyflies (data of Neural-Swarm2, T-RO 2021) are:

| rows | rule |
|---|---|
| known | measured for this vehicle, and for every other that is not away |
| usable | known, z_i > 0.3 m, no motor saturated |
| free | usable, and for every neighbour dxy > 0.3 m or dz < 0.05 m (dz = z_j - z_i); at least 200 |
| exposed | usable, and some neighbour at dxy < 0.15 m and 0.1 < dz < 1.2 m |
| upper | usable, a neighbour at dxy < 0.1 m and -0.8 < dz < -0.15 m, none above within 0.3 m |

A vehicle is away while it is not measured for 2 s (it stands, or has left) at more than 0.5 m horizontally.

    R2 = 1 - mean((y - eta)^2) / mean(y^2)  over exposed rows, pooled over flights

R2 20 ms ahead is the same with y^ of q2q_model.identification.push.residual in place of eta.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from q2q_model.downwash.interaction_model import InteractionModel
from q2q_model.identification.push.along_flight import Motion, eta_on_vehicle
from q2q_model.identification.push.residual import predicted_residual
from q2q_model.signals.values import Array, Mask, Names

FLOOR = 0.3
"""Height below which there is ground effect [m]."""
ABSENT_S = 2.0
"""Time without a measurement from which a vehicle is away [s]: gaps of recorded flights are up to 0.8 s."""
ABSENT_APART = 0.5
"""Minimum horizontal distance of a vehicle that is away [m]: there is no observable downwash beyond."""
FEWEST_FREE = 200
"""Fewest free rows for the median."""
APART = 0.3
"""Horizontal distance beyond which a neighbour does not count as above [m]."""
HARDLY_ABOVE = 0.05
"""Height difference below which one does not, whatever the distance [m]."""
UNDER = 0.15
"""Horizontal distance of exposed rows [m]."""
GAPS = (0.1, 1.2)
"""Height differences of exposed rows [m]."""
OVER = 0.1
"""Horizontal distance of upper rows [m]."""
OVER_GAPS = (0.15, 0.8)
"""Height differences of upper rows [m]."""


@dataclass(frozen=True, slots=True)
class PushRecord:
    """Flight with its measured vertical push."""

    name: str
    names: Names
    motion: Motion
    push: Array
    """y before its median is subtracted [m/s^2], (T, n)."""
    measured: Mask
    """Whether values were measured, not interpolated, (T, n)."""
    saturated: Mask
    """Whether a motor was at its limit, (T, n)."""


@dataclass(frozen=True, slots=True)
class PushSamples:
    """Samples of the push on one vehicle of one flight."""

    flight: str
    motion: Motion
    vehicle: int
    y: Array
    """[m/s^2], (T,)."""
    usable: Mask
    exposed: Mask
    upper: Mask


@dataclass(frozen=True, slots=True)
class PushScore:
    """Prediction scores of a model; None without rows."""

    r2_exposed: float | None
    """None also if no push was felt: it is relative to that."""
    rmse_exposed_mps2: float | None
    mean_upper_mps2: float | None
    """Mean of y over upper rows [m/s^2]."""
    n: int
    """Number of exposed rows."""
    r2_ahead_20ms: float | None = None
    """R2 of the prediction 20 ms ahead, with the residual known by then."""


def push_samples(record: PushRecord) -> list[PushSamples]:
    """Return the samples of every vehicle with enough free rows."""
    found = []
    for i, rows in enumerate(scored_rows(record)):
        if rows.free.sum() >= FEWEST_FREE:
            y = record.push[:, i] - np.median(record.push[rows.free, i])
            found.append(PushSamples(record.name, record.motion, i, y, rows.usable, rows.exposed, rows.upper))
    return found


def score(model: InteractionModel, samples: Sequence[PushSamples]) -> PushScore:
    """Return the score of a model, pooled over samples."""
    exposed = [one for one in samples if one.exposed.any()]
    y = [one.y[one.exposed] for one in exposed]
    residuals = [residual_of(model, one) for one in exposed]
    misses = [residual[one.exposed] for one, residual in zip(exposed, residuals, strict=True)]
    ahead = [
        (residual - predicted_residual(one.motion.t, residual, one.usable))[one.exposed]
        for one, residual in zip(exposed, residuals, strict=True)
    ]
    found = pooled_score(y, misses, samples)
    return replace(found, r2_ahead_20ms=pooled_score(y, ahead, samples).r2_exposed)


def residual_of(model: InteractionModel, one: PushSamples) -> Array:
    """Return y - eta [m/s^2], (T,); 0 in rows that are not usable."""
    rows = np.nonzero(one.usable)[0]
    residual = np.zeros(len(one.y))
    residual[rows] = one.y[rows] - eta_on_vehicle(model, one.motion, one.vehicle, rows)[:, 2]
    return residual


def pooled_score(y: Sequence[Array], misses: Sequence[Array], samples: Sequence[PushSamples]) -> PushScore:
    """Return the score of residuals y - eta over exposed rows."""
    upper = np.concatenate([one.y[one.upper] for one in samples]) if samples else np.empty(0)
    mean_upper = float(upper.mean()) if upper.size else None
    n = sum(part.size for part in y)
    if n == 0:
        return PushScore(r2_exposed=None, rmse_exposed_mps2=None, mean_upper_mps2=mean_upper, n=0)
    missed = sum(float(part @ part) for part in misses)
    total = sum(float(part @ part) for part in y)
    r2 = 1.0 - missed / total if total > 0.0 else None
    return PushScore(r2, float(np.sqrt(missed / n)), mean_upper, n)


@dataclass(frozen=True, slots=True)
class ScoredRows:
    """Rows of one vehicle by the rules of the scoring, (T,)."""

    usable: Mask
    free: Mask
    exposed: Mask
    upper: Mask


def scored_rows(record: PushRecord) -> list[ScoredRows]:
    """Return the rows of every vehicle."""
    return [_rows_of_vehicle(record, i, known) for i, known in enumerate(known_rows(record).T)]


def _rows_of_vehicle(record: PushRecord, i: int, known: Mask) -> ScoredRows:
    others = [j for j in range(len(record.names)) if j != i]
    pos = record.motion.pos
    rel = pos[:, others] - pos[:, i : i + 1]
    across, dz = np.hypot(rel[..., 0], rel[..., 1]), rel[..., 2]
    usable = known & (pos[:, i, 2] > FLOOR) & ~record.saturated[:, i]
    above = (across < APART) & (dz > 0.0)
    over = (across < OVER) & (dz > -OVER_GAPS[1]) & (dz < -OVER_GAPS[0])
    return ScoredRows(
        usable=usable,
        free=usable & ((across > APART) | (dz < HARDLY_ABOVE)).all(axis=1),
        exposed=usable & ((across < UNDER) & (dz > GAPS[0]) & (dz < GAPS[1])).any(axis=1),
        upper=usable & over.any(axis=1) & ~above.any(axis=1),
    )


def known_rows(record: PushRecord) -> Mask:
    """Return where a vehicle was measured, and every other that is not away, (T, n)."""
    across, absent = record.motion.pos[..., :2], _absent(record)
    known = np.empty_like(record.measured)
    for i in range(len(record.names)):  # not all at once: (T, n, n) of 100 vehicles is gigabytes
        apart = np.linalg.norm(across - across[:, i : i + 1], axis=-1) > ABSENT_APART  # (T, n)
        known[:, i] = (record.measured | (absent & apart)).all(axis=1)
    return known


def _absent(record: PushRecord) -> Mask:
    """Return the rows of stretches of at least ABSENT_S without a measurement, (T, n)."""
    found, t = np.zeros_like(record.measured), record.motion.t
    for i, measured in enumerate(record.measured.T):
        edges = np.flatnonzero(np.diff(np.concatenate(([False], ~measured, [False]))))
        for first, end in edges.reshape(-1, 2):
            found[first:end, i] = t[end - 1] - t[first] >= ABSENT_S
    return found


def unmeasured_note(record: PushRecord) -> str:
    """Return a note on the vehicles without any measurement; empty if there is none."""
    never = [name for name, own in zip(record.names, record.measured.T, strict=True) if not own.any()]
    return f"{record.name}: no measurements of {', '.join(never)}" if never else ""
