"""References of a bag of other software: at each tick, the last one received.

References belong to the clock of the poses, at the latest HELD_S before the first of these. They may be as
rare as goals are, of which each holds until the next, and the last one to the end of the poses. After the
last one of a stream a vehicle lands, or another program leads it: there is no reference then.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import inf

import numpy as np

from q2q_model.bag.foreign.pose_frames import clock_mismatch
from q2q_model.flights.flight import Flight
from q2q_model.flights.sampled_reference import HOLD_S
from q2q_model.signals.values import Array

HELD_S = 3.0
"""Age of a reference from which it is reported as held [s], and the time before the last one that tells a
stream from goals, unless it moves for longer than HOLD_S, more than KEYS times."""
KEYS = 3
"""Moves that goals make in a row, as of keys that are pressed."""
HELD_PERIODS = 3.0
"""Age of the last reference of a stream from which there is none [periods]."""


@dataclass(frozen=True, slots=True)
class References:
    """References of one vehicle in the order of their stamps; NaN where a message carries none."""

    t: Array
    """(rows,) [s]."""
    pos: Array
    """(rows, 3) [m], world."""
    vel: Array
    """(rows, 3) [m/s], world."""
    acc: Array
    """(rows, 3) [m/s^2], world."""


def with_references(flight: Flight, given: Mapping[str, References]) -> tuple[Flight, list[str]]:
    """Return the flight with its references, and remarks on pauses and ends of the references.

    Raises:
        ValueError: references of a vehicle that the flight has not, or on another clock.
    """
    made = replace(
        flight,
        ref_pos=flight.ref_pos.copy(),
        ref_vel=flight.ref_vel.copy(),
        ref_acc=flight.ref_acc.copy(),
    )
    remarks = []
    for vehicle, track in given.items():
        if vehicle not in flight.names:
            raise ValueError(
                f"references of unknown vehicle {vehicle}; choose one of {', '.join(flight.names)}"
            )
        if misfit := clock_mismatch(f"references of {vehicle}", track.t, flight.t, HELD_S):
            raise ValueError(misfit)
        row, end = np.searchsorted(track.t, flight.t, side="right") - 1, _end(track)
        known = (row >= 0) & (flight.t <= end)
        for held, values in (
            (made.ref_pos, track.pos),
            (made.ref_vel, track.vel),
            (made.ref_acc, track.acc),
        ):
            held[known, flight.names.index(vehicle)] = values[row[known]]
        remarks += _pauses(vehicle, track.t, flight.t)
        if (late := flight.t[-1] - track.t[-1]) > HELD_S:
            then = "the last is held" if end == inf else f"none after {end:.3f} s"
            ends = f"references of {vehicle} end at t = {track.t[-1]:.3f} s, {late:.1f} s before the poses"
            remarks.append(f"{ends}: {then}")
    return made, remarks


def _end(track: References) -> float:
    """Return the time until which the last reference counts [s], infinite for a goal.

    Half of the HELD_S before it, or of the messages in which it moves, is in steps of a period or less, in
    which bursts weigh little.
    """
    t = track.t
    began = np.flatnonzero(np.diff(t, prepend=-inf) > HOLD_S)[-1]  # of its messages without a pause
    moves = began + np.flatnonzero((np.diff(np.nan_to_num(track.pos[began:]), axis=0) != 0.0).any(axis=1))
    moved = len(moves) > KEYS and t[moves[-1] + 1] - t[moves[0]] > HOLD_S
    start = max(t[began], t[-1] - HELD_S) if moved else t[-1] - HELD_S
    steps = np.sort(np.diff(t[t > start], prepend=start))
    period = float(steps[np.searchsorted(np.cumsum(steps), 0.5 * (t[-1] - start))])
    return float(t[-1]) + HELD_PERIODS * period if period <= HOLD_S else inf


def _pauses(vehicle: str, t: Array, ticks: Array) -> list[str]:
    """Return a remark if a tick has an older reference than HELD_S, and newer ones come later."""
    row = np.searchsorted(t, ticks, side="right") - 1
    age = np.where((row >= 0) & (row < len(t) - 1), ticks - t[np.clip(row, 0, None)], 0.0)
    oldest = int(np.argmax(age))
    if age[oldest] <= HELD_S:
        return []
    return [f"references of {vehicle} pause for {age[oldest]:.1f} s after t = {t[row[oldest]]:.3f} s: held"]
