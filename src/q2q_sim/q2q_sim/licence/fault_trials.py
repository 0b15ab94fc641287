"""Trials with a fault, guided by the flight without: each at an instant where that has its least margins.

The instants are those of the largest speed, of the smallest distance of two vehicles in the air (if they fly
one after another, of the largest speed), half a second after the take-off, and one second before the landing
(0 s if that is in the first second).
"""

from dataclasses import replace
from itertools import combinations

import numpy as np

from q2q_model.signals.values import Array
from q2q_sim.licence.room.licence_log import LicenceLog
from q2q_sim.licence.room.trials import LicenceTrial, TrialKind

AFTER_RISE_S = 0.5
BEFORE_LANDING_S = 1.0


def trials_after(nominal: LicenceLog) -> tuple[LicenceTrial, ...]:
    """Return the trials with a fault, guided by the flight without; none if nothing flew."""
    rows = np.flatnonzero(nominal.flew).tolist()
    if not rows:
        return ()
    fast, fastest = _fastest(nominal)
    first, last = rows[0], rows[-1]
    rise, landing = _span(nominal, fast)
    descent = max(landing - BEFORE_LANDING_S, 0.0)
    found = [
        LicenceTrial(TrialKind.GAP, fast, fastest),
        LicenceTrial(TrialKind.GAP, fast, descent),
        LicenceTrial(TrialKind.STALE, fast, fastest),
        LicenceTrial(TrialKind.STALE, fast, descent),
        LicenceTrial(TrialKind.BATTERY, fast, rise + AFTER_RISE_S),
        LicenceTrial(TrialKind.PUSH, fast, fastest),
        LicenceTrial(TrialKind.PUSH, last, _span(nominal, last)[0] + AFTER_RISE_S),
        LicenceTrial(TrialKind.UNARMED, first),
    ]
    if len(rows) > 1:
        one, other, nearest = _nearest(nominal, rows)
        found += [
            LicenceTrial(TrialKind.UNARMED, last),
            LicenceTrial(TrialKind.SWAP, one, nearest, other),
            LicenceTrial(TrialKind.LOST, one, nearest),
            LicenceTrial(TrialKind.LOST, first, _span(nominal, first)[0] + AFTER_RISE_S),
        ]
    return tuple(replace(one, names=nominal.names) for one in found)


def _fastest(log: LicenceLog) -> tuple[int, float]:
    """Return the fastest vehicle and the time of its largest speed [s]."""
    speed = np.linalg.norm(log.vel, axis=-1) * log.airborne  # (T, n)
    tick, row = np.unravel_index(int(np.argmax(speed)), speed.shape)
    return int(row), float(log.t[tick])


def _span(log: LicenceLog, row: int) -> tuple[float, float]:
    """Return the first and last time of a vehicle in the air [s]."""
    ticks = np.flatnonzero(log.airborne[:, row])
    return float(log.t[ticks[0]]), float(log.t[ticks[-1]])


def _nearest(log: LicenceLog, rows: list[int]) -> tuple[int, int, float]:
    """Return the two vehicles that are nearest to each other in the air, and when [s]."""
    pairs = list(combinations(rows, 2))
    gaps = np.stack([_gap(log, i, j) for i, j in pairs])  # (pairs, T)
    best, tick = np.unravel_index(int(np.argmin(gaps)), gaps.shape)
    if np.isinf(gaps[best, tick]):
        return _nearest_to_fastest(log, rows)
    return *pairs[int(best)], float(log.t[tick])


def _nearest_to_fastest(log: LicenceLog, rows: list[int]) -> tuple[int, int, float]:
    """Return the fastest vehicle, the one nearest to it then, in the air or not, and when that is [s]."""
    fast, t = _fastest(log)
    distance = np.linalg.norm(log.pos - log.pos[:, [fast]], axis=-1)[log.t == t][0]  # (n,)
    return fast, min((row for row in rows if row != fast), key=distance.__getitem__), t


def _gap(log: LicenceLog, i: int, j: int) -> Array:
    """Return the distance of two vehicles [m], infinite unless both are in the air, (T,)."""
    distance = np.linalg.norm(log.pos[:, i] - log.pos[:, j], axis=-1)
    both = log.airborne[:, i] & log.airborne[:, j]
    return np.asarray(np.where(both, distance, np.inf))
