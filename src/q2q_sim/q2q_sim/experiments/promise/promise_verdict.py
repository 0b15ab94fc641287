"""Verdict on many encounters: zone entries, ticks with a broken promise, flights that leave a tube.

A rate of k in n has the upper bound of Clopper and Pearson (1934) at a confidence of 95 %.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import betaincinv

from q2q_model.documents.json_file import Json
from q2q_model.signals.values import Array
from q2q_sim.experiments.promise.room_encounter import EncounterRecord
from q2q_sim.experiments.promise.tracking_tube import TrackingTube

CONFIDENCE = 0.95


@dataclass(frozen=True, slots=True)
class Rate:
    """Events k in n flights."""

    events: int
    flights: int

    @property
    def most(self) -> float:
        """Return the upper bound of the rate at CONFIDENCE."""
        if self.events >= self.flights:
            return 1.0
        return float(betaincinv(self.events + 1, self.flights - self.events, CONFIDENCE))


@dataclass(frozen=True, slots=True)
class PromiseVerdict:
    """Counts of many encounters."""

    flights: int
    vehicles: int
    entries: Rate
    """Flights in which a vehicle entered a zone, of those that begin under the conditions."""
    entries_otherwise: int
    """Of the others."""
    silent: int
    """Flights with an entry that was not announced."""
    clearance: float
    """Minimum distance of two vehicles to the zone in flights that begin under the conditions [m]."""
    ticks: int
    broken_ticks: int
    """Both of flights that begin under the conditions."""
    left_tube: Rate | None
    """Flights under the conditions in which a vehicle left the tube that was flown; None without a tube."""
    arrived: Rate
    """Flights whose vehicles are all back on their references, of those whose ends are clear."""
    in_reach: Rate
    """Of these, flights in which the bounds of motion let every vehicle be back, were it alone."""


def largest_errors(records: Sequence[EncounterRecord]) -> Array:
    """Return the largest tracking errors (horizontal, vertical) [m], (n, 2), in the order of the seeds.

    Only of flights that begin under the conditions.
    """
    known = sorted((one for one in records if one.apart_at_start), key=lambda one: one.seed)
    return np.array([(one.horizontal, one.vertical) for one in known]).reshape(-1, 2)


def promise_verdict(records: Sequence[EncounterRecord], tube: TrackingTube | None) -> PromiseVerdict:
    """Return the verdict on flights; `tube` is the one they were flown with."""
    held = [one for one in records if one.apart_at_start]
    others = [one for one in records if not one.apart_at_start]
    left = None
    if tube is not None:
        left = Rate(sum(not tube.holds(errors) for errors in largest_errors(records)), len(held))
    ends = [one.arrived for one in held if one.arrived is not None]
    reach = [one.in_reach for one in held if one.in_reach is not None]
    return PromiseVerdict(
        flights=len(records),
        vehicles=sum(one.vehicles for one in records),
        entries=Rate(sum(one.entered for one in held), len(held)),
        entries_otherwise=sum(one.entered for one in others),
        silent=sum(one.entered and not one.announced for one in records),
        clearance=min((one.clearance for one in held), default=float("inf")),
        ticks=sum(one.ticks for one in held),
        broken_ticks=sum(one.broken_ticks for one in held),
        left_tube=left,
        arrived=Rate(sum(ends), len(ends)),
        in_reach=Rate(sum(reach), len(reach)),
    )


def verdict_json(found: PromiseVerdict) -> Json:
    """Return a verdict as plain values: the contract of `promise --json`; what is unknown is null."""
    return {
        "flights": found.flights,
        "vehicles": found.vehicles,
        "under_conditions": found.entries.flights,
        "entries_under_conditions": found.entries.events,
        "entry_rate_most": found.entries.most,
        "entries_otherwise": found.entries_otherwise,
        "entries_not_announced": found.silent,
        "least_distance_m": found.clearance,
        "ticks": found.ticks,
        "broken_ticks": found.broken_ticks,
        "left_tube": found.left_tube.events if found.left_tube else None,
        "left_tube_rate_most": found.left_tube.most if found.left_tube else None,
        "arrived": found.arrived.events,
        "can_arrive": found.arrived.flights,
        "in_reach": found.in_reach.events,
    }


def verdict_lines(found: PromiseVerdict) -> Sequence[str]:
    """Return a verdict as lines of text."""
    entries, arrived = found.entries, found.arrived
    broken = found.broken_ticks / max(found.ticks, 1)
    bound = f"rate below {entries.most:.2g} (95 %)"
    lines = [
        f"{found.flights} flights of {found.vehicles} vehicles; {entries.flights} begin under the conditions",
        f"under the conditions: {entries.events} zone entries, {bound}",
        f"    smallest distance to a zone: {1e3 * found.clearance:.0f} mm",
        f"    ticks with a broken promise: {found.broken_ticks} of {found.ticks} ({broken:.2%})",
        f"    flights that end on the references: {arrived.events} of {arrived.flights}",
        f"    flights that could if every vehicle flew alone: {found.in_reach.events}",
        f"otherwise: {found.entries_otherwise} zone entries; of all, {found.silent} not announced",
    ]
    if found.left_tube is not None:
        left = found.left_tube
        share, bound = left.events / max(left.flights, 1), f"below {left.most:.2%} (95 %)"
        lines.append(f"left the tube: {left.events} of {left.flights} flights ({share:.2%}), {bound}")
    return lines
