"""Policies on pairs: separation, and no unplanned entry into the interference zone."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from q2q_model.signals.values import Array
from q2q_sim.monitors.metrics.proximity import in_zone_once, least_distances
from q2q_sim.monitors.policies.exemptions.feedback_loss import evading_lately, without_feedback_lately
from q2q_sim.monitors.policies.exemptions.sensor_errors import marker_displacement, with_sensor_error
from q2q_sim.monitors.policies.exemptions.unpredicted_downwash import (
    exempt_lately,
    unpredicted_downwash_lately,
)
from q2q_sim.monitors.policies.inputs.circumstances import Circumstances
from q2q_sim.monitors.policies.inputs.flight_trace import FlightTrace
from q2q_sim.monitors.policies.violations import Violation


class _Worst(NamedTuple):
    """Worst moment of a pair."""

    tick: int
    value: float
    limit: float


def separation(trace: FlightTrace, circumstances: Circumstances) -> list[Violation]:
    """Return the pairs closer than allowed, by more than their markers are displaced.

    Pairs of a vehicle in a downwash that nothing could predict are exempt until `settle` later.
    """
    limit, pos = circumstances.limits.separation, trace.true_pos
    moved = marker_displacement(trace, circumstances.faults)
    moved[unpredicted_downwash_lately(trace, circumstances)] = np.inf
    found = []
    for (i, j), distance in close_pairs(pos, limit):
        apart = distance + moved[:, i] + moved[:, j]
        tick = int(np.nanargmin(apart))
        if apart[tick] < limit:
            worst = _Worst(tick, float(apart[tick]), limit)
            found.append(_violation("separation", trace, (i, j), worst))
    return found


def close_pairs(pos: Array, limit: float) -> Iterator[tuple[tuple[int, int], Array]]:
    """Yield each pair i < j that comes closer than `limit` [m], and its distance [m], (T,)."""
    for i, j in np.argwhere(least_distances(pos) < limit).tolist():
        yield (i, j), np.asarray(np.linalg.norm(pos[:, i] - pos[:, j], axis=1))


def zone(trace: FlightTrace, circumstances: Circumstances) -> list[Violation]:
    """Return the pairs in the zone though their setpoints clear it by `stray`.

    Vehicles without measurements drift, vehicles near them evade, vehicles with displaced markers follow
    them, and uncontrollable vehicles sink: their pairs are exempt until `settle` later.
    """
    found = []
    entered = in_zone_once(trace.true_pos, circumstances.zone)
    for pair, inside in clearances(trace, circumstances, entered):
        deepest = _lowest(inside)
        if deepest is not None and inside[deepest] < 0.0:
            worst = _Worst(deepest, float(inside[deepest]), 0.0)
            found.append(_violation("zone", trace, pair, worst))
    return found


def clearances(
    trace: FlightTrace, circumstances: Circumstances, pairs: Sequence[tuple[int, int]]
) -> Iterator[tuple[tuple[int, int], Array]]:
    """Yield each pair and its distance from the zone [m], (T,); NaN at ticks that are not judged."""
    settle = circumstances.limits.settle
    lost = without_feedback_lately(trace, settle) | evading_lately(trace, settle)
    lost |= with_sensor_error(trace, circumstances.faults, settle) | exempt_lately(trace, circumstances)
    for i, j in pairs:
        real, meant = (
            circumstances.zone.signed_distance(pos[:, j] - pos[:, i])
            for pos in (trace.true_pos, trace.sent_pos)
        )
        sighted = ~(lost[:, i] | lost[:, j])
        yield (i, j), np.where(sighted & (meant > circumstances.limits.stray), real, np.nan)


def _lowest(values: Array) -> int | None:
    """Return the index of the lowest value; None without values."""
    known = np.where(np.isfinite(values), values, np.inf)
    return int(known.argmin()) if len(known) and np.isfinite(known.min()) else None


def _violation(policy: str, trace: FlightTrace, pair: tuple[int, int], worst: _Worst) -> Violation:
    who = f"{trace.names[pair[0]]} and {trace.names[pair[1]]}"
    return Violation(policy, who, float(trace.t[worst.tick]), worst.value, worst.limit)
