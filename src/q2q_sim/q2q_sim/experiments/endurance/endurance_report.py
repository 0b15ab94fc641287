"""Growth of what a long flight's processes hold, as words, table and JSON.

| quantity | flat |
|---|---|
| memory of each process | within 20 MB per hour |
| handles and threads of each process | within 1 per hour |
| rate of the bag | within 5 % of its mean an hour |
| clock, live | time of the flight within 36 ms of the wall clock an hour (10 ppm) |

The speed of a flight in lockstep depends on what else the machine does; it is reported and not judged.
"""

from collections.abc import Sequence
from math import isfinite

import numpy as np
from rich.table import Table

from q2q_model.counted import counted
from q2q_model.documents.json_file import Json
from q2q_model.signals.values import Array
from q2q_sim.experiments.endurance.growth import Growth, WatchedQuantity, growth
from q2q_sim.experiments.endurance.long_flight import LongFlight
from q2q_sim.node_flights.unfinished_bag import REMEDY

MEGABYTE = 1e6
MEMORY_MB, COUNT, RATE_SHARE, DRIFT_S = 20.0, 1.0, 0.05, 0.036
"""Allowed an hour."""
WINDOWS = 64
"""Most parts of a flight in each of which the bag's rate is read: longer than its chunks, in an hour."""


def measured_growths(flight: LongFlight) -> list[Growth]:
    """Return the growth of every quantity; raise ValueError for a flight of fewer than two samples."""
    samples = flight.samples
    if len(samples) < 2:
        raise ValueError(f"{counted(len(samples), 'sample')}; must be at least 2; fly longer")
    t = np.array([one.flown for one in samples])
    found = []
    for name in samples[0].usage:
        held = [one.usage[name] for one in samples]
        memory = np.array([one.memory / MEGABYTE for one in held])
        handles = np.array([float(one.handles) for one in held])
        threads = np.array([float(one.threads) for one in held])
        found += [
            growth(WatchedQuantity(f"{name}: memory", "MB", MEMORY_MB), t, memory),
            growth(WatchedQuantity(f"{name}: handles", "", COUNT), t, handles),
            growth(WatchedQuantity(f"{name}: threads", "", COUNT), t, threads),
        ]
    found.append(bag_rate(t, np.array([float(one.bag) for one in samples])))
    if flight.live:
        ahead = t - t[0] - np.array([one.wall - samples[0].wall for one in samples])
        found.append(growth(WatchedQuantity("clock ahead of the wall clock", "s", DRIFT_S), t, ahead))
    return found


def bag_rate(t: Array, size: Array) -> Growth:
    """Return the growth of the rate [kB/s of flight] of a bag of `size` (m,) [bytes] at times t (m,) [s]."""
    parts = min(WINDOWS, len(t) - 1)
    ends = np.linspace(0, len(t) - 1, parts + 1).astype(np.intp)
    rate = np.diff(size[ends]) / np.diff(t[ends]) / 1000.0
    middle = 0.5 * (t[ends[1:]] + t[ends[:-1]])
    return growth(WatchedQuantity("bag", "kB/s", RATE_SHARE * float(rate.mean())), middle, rate)


def growth_table(flight: LongFlight, found: Sequence[Growth]) -> Table:
    """Return the growth of every quantity as a table."""
    kind, minutes = "live" if flight.live else "lockstep", flight.samples[-1].flown / 60.0
    vehicles, samples = counted(flight.vehicles, "vehicle"), len(flight.samples)
    made = Table(title=f"{vehicles}, {minutes:.1f} min, {kind}, {samples} samples")
    for column in ("quantity", "mean", "an hour", "95 % interval", "unit", ""):
        left = column in ("quantity", "unit", "")
        made.add_column(column, justify="left" if left else "right", no_wrap=column != "quantity")
    for one in found:
        mean, slope, low, high = (f"{value:.4g}" for value in (one.mean, one.per_hour, one.low, one.high))
        known = isfinite(one.per_hour)
        cells = (slope, f"{low} to {high}") if known else ("-", "-")
        made.add_row(one.what, mean, *cells, one.unit, one.verdict)
    return made


def is_flat(flight: LongFlight, found: Sequence[Growth]) -> bool:
    """Return whether every quantity stayed flat, and the bag holds the flight to its end."""
    return not flight.unfinished and all(one.verdict == "flat" for one in found)


def endurance_sentence(flight: LongFlight, found: Sequence[Growth]) -> str:
    """Return what a flight showed, in one line."""
    timing, speed = flight.timing, flight.timing.real_time_factor
    flown = f"{flight.samples[-1].flown / 60.0:.0f} min of {counted(flight.vehicles, 'vehicle')}"
    pace = f"{timing.missed_ticks} of {timing.ticks} ticks missed, {speed or 0.0:.1f} times real time"
    rest = [f"{one.what} {one.verdict}" for one in found if one.verdict != "flat"]
    if flight.unfinished:
        rest.append(f"the bag does not hold the flight to its end ({flight.unfinished}): {REMEDY}")
    return f"{flown}: {'all flat' if not rest else '; '.join(rest)} ({len(found)} quantities; {pace})"


def endurance_json(flight: LongFlight, found: Sequence[Growth]) -> Json:
    """Return the numbers of a flight: the contract of `endurance --json`."""
    quantities: list[Json] = [
        {
            "quantity": one.what,
            "unit": one.unit,
            "mean": one.mean,
            "per_hour": one.per_hour,
            "low": one.low,
            "high": one.high,
            "allowed": one.allowed,
            "verdict": one.verdict,
        }
        for one in found
    ]
    return {
        "vehicles": flight.vehicles,
        "live": flight.live,
        "flown_s": flight.samples[-1].flown,
        "samples": len(flight.samples),
        "ticks": flight.timing.ticks,
        "missed_ticks": flight.timing.missed_ticks,
        "real_time_factor": flight.timing.real_time_factor,
        "flat": is_flat(flight, found),
        "sentence": endurance_sentence(flight, found),
        "quantities": quantities,
    }
