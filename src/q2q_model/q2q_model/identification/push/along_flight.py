"""An interaction model evaluated along a recorded flight, all ticks at once.

The sum is that of the online predictor (q2q_model.downwash.predictor), as a test checks:

    eta_i(t) = sum over j of s_ij law(r_j(t - tau) - r_i(t), v_j(t - tau), b_j(t - tau), v_i(t))

with the strengths s of q2q_model.downwash.source_strength. The past of a vehicle is the whole record,
extended before its start by the first sample.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import groupby

import numpy as np

from q2q_model.downwash.interaction_model import InteractionModel, SourceStates, downwash, retarded_pairs
from q2q_model.downwash.source_strength import (
    HALF_SPAN_S,
    PAIRS_ALONE,
    SourceTerms,
    source_terms,
    strengths,
    thrust_ratio,
)
from q2q_model.downwash.state_history import states_at
from q2q_model.geometry.pair_reach import SLACK
from q2q_model.identification.gains.altitude_record import AltitudeRecord
from q2q_model.signals.values import Array, Mask, Rows


@dataclass(frozen=True, slots=True)
class Motion:
    """Motion of a swarm over time, without gaps."""

    t: Array
    """[s], rising, (T,)."""
    pos: Array
    """[m], world, (T, n, 3)."""
    vel: Array
    """[m/s], world, (T, n, 3)."""
    axis: Array
    """Body z, world, (T, n, 3)."""


def motion_along(record: AltitudeRecord) -> Motion:
    """Return the motion in a record."""
    return Motion(record.t, record.pos, record.vel, record.axis)


@dataclass(frozen=True, slots=True)
class VehicleTicks:
    """One vehicle of a flight at some ticks."""

    motion: Motion
    vehicle: int
    ticks: Rows
    """(k,)."""


class FlownRows:
    """Vehicles of flights at some ticks, gathered once for the evaluation of many models.

    All are evaluated at once: a fit has some tens of rows of a vehicle, and calls cost more than rows.
    """

    def __init__(self, parts: Sequence[VehicleTicks]) -> None:
        """Gather `parts`, whose rows follow each other."""
        runs = groupby(parts, key=lambda one: one.motion.pos.shape[1])
        self._runs = [_EqualSwarms(list(run)) for _, run in runs]

    def eta(self, model: InteractionModel) -> Array:
        """Return eta of the vehicles [m/s^2], (k, 3)."""
        return np.concatenate([run.eta(model) for run in self._runs])


@dataclass(frozen=True, slots=True)
class _PairRows:
    """States of P pairs at k rows, those of a pair one after another."""

    shape: tuple[int, int]
    """P, k."""
    t: Array
    """[s], (P * k,)."""
    flight: Rows
    """Number of the flight, (P * k,)."""
    source: Rows
    """Number of the source in its flight, (P * k,)."""
    feels: Array
    """pos, vel, axis of the vehicle that feels, (P * k, 9)."""
    causes: Array
    """Of the source, (P * k, 9)."""
    across2: Array
    """Square of the horizontal distance [m^2], (P * k,)."""
    apart: Array
    """|dz| [m], (P * k,)."""


class _EqualSwarms:
    """Rows of flights of n vehicles each; the flights follow each other on one clock."""

    def __init__(self, parts: Sequence[VehicleTicks]) -> None:
        self._motions = motions = list({id(one.motion): one.motion for one in parts}.values())
        clocks = _one_clock([motion.t for motion in motions])
        begins = np.cumsum([0, *(clock.size for clock in clocks)])
        place = {id(motion): k for k, motion in enumerate(motions)}
        flight, sizes = [place[id(one.motion)] for one in parts], [one.ticks.size for one in parts]
        self._t = np.concatenate(clocks)  # (T,)
        swarms = [np.concatenate((one.pos, one.vel, one.axis), axis=2) for one in motions]
        self._states = np.concatenate(swarms)  # (T, n, 9)
        self._vehicle = np.repeat([one.vehicle for one in parts], sizes)  # (k,)
        self._flight = np.repeat(flight, sizes)  # (k,)
        self._first = self._t[begins[:-1]]  # of every flight
        self._tick = np.concatenate([one.ticks for one in parts]) + begins[self._flight]  # (k,)

    def eta(self, model: InteractionModel) -> Array:
        """Return eta of the vehicles [m/s^2], (k, 3)."""
        terms = source_terms(model)
        if terms == PAIRS_ALONE:
            return np.asarray(self._law(model, self._own_pairs).sum(axis=0))
        feels, causes = _ordered_pairs(self._states.shape[1])
        law = self._law(model, self._every_pair)
        share = strengths(feels, causes, law[..., 2], self._thrust_ratio(model, terms), terms)
        own = np.where(feels[:, None] == self._vehicle, share, 0.0)
        return np.asarray((own[..., None] * law).sum(axis=0))

    def _law(self, model: InteractionModel, rows: _PairRows) -> Array:
        """Return the downwash of each source alone, (P, k, 3)."""
        near = np.flatnonzero(self._near(model, rows))
        feels, eta = rows.feels[near], np.zeros((rows.t.size, 3))

        def past(delay: Array) -> SourceStates:
            when = np.maximum(rows.t[near] - delay, self._first[rows.flight[near]])
            return SourceStates.of_rows(states_at(self._t, self._states, when, rows.source[near]))

        pairs = retarded_pairs(
            model, feels[:, :3], feels[:, 3:6], SourceStates.of_rows(rows.causes[near]), past
        )
        eta[near] = downwash(model, pairs)
        return eta.reshape(*rows.shape, 3)

    def _near(self, model: InteractionModel, rows: _PairRows) -> Mask:
        """Return a search for pairs, (P * k,): within reach, allowing for the source's way in the delay."""
        wide, tall = model.reach.horizontal, model.reach.vertical
        speed = self._fastest[rows.flight, rows.source] if model.max_delay > 0.0 else 0.0
        moved = model.max_delay * speed + SLACK
        return np.asarray((rows.across2 <= (wide + moved) ** 2) & (rows.apart <= tall + moved))

    def _thrust_ratio(self, model: InteractionModel, terms: SourceTerms) -> Array:
        """Return thrust over weight of every source when its air left it, (P, k); 1 if it has no effect."""
        rows = self._every_pair
        if terms.loading == 0.0:
            return np.ones(rows.shape)
        left = rows.t - model.delay(rows.causes[:, :3] - rows.feels[:, :3])
        before, after = left - HALF_SPAN_S, np.minimum(left + HALF_SPAN_S, rows.t)
        vel = [
            states_at(self._t, self._vel, np.maximum(when, self._first[rows.flight]), rows.source)
            for when in (before, after)
        ]
        return thrust_ratio(vel[0], vel[1], after - before).reshape(rows.shape)

    @cached_property
    def _fastest(self) -> Array:
        """Largest speed from sample to sample of every vehicle of every flight [m/s], (flights, n)."""
        return np.stack([_largest_speed(one) for one in self._motions])

    @cached_property
    def _vel(self) -> Array:
        """Velocities [m/s], (T, n, 3)."""
        return np.concatenate([one.vel for one in self._motions])

    @cached_property
    def _own_pairs(self) -> _PairRows:
        """Pairs of every row's vehicle with the n - 1 others, ascending."""
        other = np.arange(self._states.shape[1] - 1)[:, None] + np.zeros_like(self._vehicle)
        return self._pairs(np.broadcast_to(self._vehicle, other.shape), other + (other >= self._vehicle))

    @cached_property
    def _every_pair(self) -> _PairRows:
        """All pairs of the swarm at every row."""
        pairs = np.stack(_ordered_pairs(self._states.shape[1]))[..., None]  # (2, P, 1)
        return self._pairs(*(pairs + np.zeros_like(self._tick)))

    def _pairs(self, feels: Rows, causes: Rows) -> _PairRows:
        """Return the states of vehicles `feels` and `causes` (P, k)."""
        source, count = causes.ravel(), feels.shape[0]
        tick, flight = np.tile(self._tick, count), np.tile(self._flight, count)
        one, other = self._states[tick, feels.ravel()], self._states[tick, source]
        rel_pos = other[:, :3] - one[:, :3]
        return _PairRows(
            shape=feels.shape,
            t=self._t[tick],
            flight=flight,
            source=source,
            feels=one,
            causes=other,
            across2=rel_pos[:, 0] ** 2 + rel_pos[:, 1] ** 2,
            apart=np.abs(rel_pos[:, 2]),
        )


def _largest_speed(motion: Motion) -> Array:
    steps = np.linalg.norm(np.diff(motion.pos, axis=0), axis=2) / np.diff(motion.t)[:, None]
    return np.asarray(steps.max(axis=0, initial=0.0))


def _one_clock(clocks: Sequence[Array]) -> list[Array]:
    """Return times [s] of flights shifted so that each begins a second after the one before it ended."""
    shifted = list(clocks[:1])
    for clock in clocks[1:]:
        shifted.append(clock - clock[0] + shifted[-1][-1] + 1.0)
    return shifted


def _ordered_pairs(n: int) -> tuple[Rows, Rows]:
    """Return the vehicles that feel and that cause, (n (n - 1),)."""
    feels, causes = np.nonzero(~np.eye(n, dtype=np.bool_))
    return feels, causes


def eta_along(model: InteractionModel, motion: Motion) -> Array:
    """Return eta [m/s^2], world, (T, n, 3)."""
    ticks, n = motion.pos.shape[:2]
    everywhere = np.arange(ticks)
    return np.stack([eta_on_vehicle(model, motion, i, everywhere) for i in range(n)], axis=1)


def eta_on_vehicle(model: InteractionModel, motion: Motion, i: int, rows: Rows) -> Array:
    """Return eta of vehicle i at ticks `rows` (k,), [m/s^2], (k, 3)."""
    return FlownRows([VehicleTicks(motion, i, rows)]).eta(model)
