"""Trace of a flight for the policies: its signals in arrays, tick by tick.

Rows are ticks, with the stamps of `truth` if recorded, else of the first topic of the data flow that is
(q2q_sim.monitors.policies.inputs.signal_tables).
"""

from collections.abc import Iterable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from q2q_model.flights.joined_flight import check_clock
from q2q_model.flights.output_ticks import output_ticks
from q2q_model.signals.layout import Signal
from q2q_model.signals.stamps import TICK_S
from q2q_model.signals.values import Array, Names
from q2q_sim.monitors.metrics.proximity import near_sample
from q2q_sim.monitors.policies.inputs.finite_numbers import first_not_finite
from q2q_sim.monitors.policies.inputs.signal_tables import SAME_TICK, Table, TickGrid, Topic

NAMING = ("truth", "reference", "reference_safe", "state", "command", "mocap")
"""Topics that give ticks and names, in order of preference."""
USED = (*NAMING, "truth_interference")
"""Topics that a trace is made of."""
SIGHT_M = 0.1
"""A sample within this distance observes the vehicle, whatever its name [m]: the paper's eps."""


@dataclass(frozen=True, slots=True)
class RecordedSignal:
    """One message of a flight."""

    topic: str
    """Without a leading slash."""
    at: float
    """Time of recording [s]; in lockstep the stamp."""
    signal: Signal


@dataclass(frozen=True, slots=True)
class FlightTrace:
    """Signals of a flight of T ticks and n vehicles."""

    t: Array
    """Stamps of the ticks [s], rising, (T,)."""
    names: Names
    true_pos: Array
    """[m], (T, n, 3)."""
    sent_pos: Array
    """Setpoints that the controller flew at each tick: reference_safe, else reference [m], (T, n, 3)."""
    asked_pos: Array
    """Setpoints of the plan, before any replanner: reference, else reference_safe [m], (T, n, 3)."""
    seen: NDArray[np.bool_]
    """Whether a frame with the tick's stamp has the vehicle, by name or by true position, (T, n)."""
    state_pos: Array
    """[m], (T, n, 3)."""
    state_age: Array
    """[s], (T, n)."""
    state_status: Array
    """TrackStatus, (T, n)."""
    thrust: Array
    """[N], (T, n)."""
    roll: Array
    """[rad], (T, n)."""
    pitch: Array
    """[rad], (T, n)."""
    command_status: Array
    """CommandStatus, (T, n)."""
    recorded_at: Array
    """Time of recording of each tick [s], (T,)."""
    commanded_at: Mapping[str, Array]
    """Times of recording of each vehicle's commands under a new stamp [s], (K,) by name."""
    live: bool
    """Bag time is wall time, so that gaps count."""
    not_finite: tuple[str, ...]
    """Signals with numbers that are not finite, one line for each topic."""
    true_downwash: Array = field(default_factory=lambda: np.full((1, 1, 3), np.nan))
    """True acceleration by the downwash [m/s^2], (T, n, 3); (1, 1, 3) if unknown."""

    @property
    def tick(self) -> float:
        """Return the time between ticks [s]."""
        return float(np.median(np.diff(self.t))) if len(self.t) > 1 else TICK_S


def trace_of(recorded: Iterable[RecordedSignal]) -> FlightTrace:
    """Return the trace from a flight's messages.

    Raises:
        ValueError: no message names vehicles and ticks.
    """
    signals: dict[str, list[Signal]] = {}
    at: dict[str, list[float]] = {}
    for one in recorded:
        signals.setdefault(one.topic, []).append(one.signal)
        at.setdefault(one.topic, []).append(one.at)
    topics = _topics(signals)
    return _trace(topics, {topic: np.array(at.get(topic, ())) for topic in topics})


def trace_in_lockstep(signals: Mapping[str, Sequence[Signal]]) -> FlightTrace:
    """Return the trace from a flight's signals by topic, recorded at their own stamps.

    Raises:
        ValueError: no signal names vehicles and ticks.
    """
    topics = _topics(signals)
    return _trace(topics, {topic: one.stamps for topic, one in topics.items()})


def _topics(signals: Mapping[str, Sequence[Signal]]) -> dict[str, Topic]:
    """Return the topics of a flight; those of the trace that it lacks are empty."""
    return {topic: Topic(signals.get(topic, ())) for topic in dict.fromkeys((*signals, *USED))}


def _trace(topics: Mapping[str, Topic], at: Mapping[str, Array]) -> FlightTrace:
    """Return the trace from topics and the times of recording of their signals [s], (K,) each."""
    ticks_of = next((topic for topic in NAMING if topics[topic].signals), None)
    if ticks_of is None:
        raise ValueError(f"no ticks: a flight needs one of {', '.join(NAMING)}")
    check_clock(ticks_of, (naming := topics[ticks_of]).stamps)
    names = tuple(dict.fromkeys(name for some in naming.by_names for name in some))
    ticks, first = np.unique(naming.stamps, return_index=True)
    grid = TickGrid(ticks, names)
    states, commands = Table(grid, topics["state"]), Table(grid, topics["command"])
    true_pos = Table(grid, topics["truth"]).column("pos", 3)
    setpoints = [topics[one] for one in ("reference_safe", "reference") if topics[one].signals]
    sent, asked = (setpoints[0], setpoints[-1]) if setpoints else (topics["reference"], topics["reference"])
    live = bool((np.abs(at["command"] - topics["command"].stamps) > SAME_TICK).any())
    return FlightTrace(
        t=grid.t,
        names=names,
        true_pos=true_pos,
        sent_pos=Table(grid, _at_ticks(sent, topics)).column("pos", 3),
        asked_pos=Table(grid, _at_ticks(asked, topics)).column("pos", 3),
        seen=_seen(grid, topics["mocap"], true_pos),
        state_pos=states.column("pos", 3),
        state_age=states.column("age", 1),
        state_status=states.column("status", 1),
        thrust=commands.column("thrust", 1),
        roll=commands.column("roll", 1),
        pitch=commands.column("pitch", 1),
        command_status=commands.column("status", 1),
        recorded_at=at[ticks_of][first],
        commanded_at=_new_commands(topics["command"], at["command"]),
        live=live,
        not_finite=first_not_finite(topics, live=live),
        true_downwash=Table(grid, topics["truth_interference"]).column("acc", 3),
    )


def _at_ticks(outputs: Topic, topics: Mapping[str, Topic]) -> Topic:
    """Return a topic of outputs, stamped with the ticks of their frames."""
    made = copy(outputs)
    made.stamps = output_ticks(topics["truth"].stamps, topics["mocap"].stamps, outputs.stamps)
    return made


def _new_commands(commands: Topic, at: Array) -> Mapping[str, Array]:
    """Return when each vehicle's commands were recorded whose stamp is not that of the one before [s]."""
    of: dict[str, list[int]] = {}
    for names, some in commands.by_names.items():
        for name in names:
            of.setdefault(name, []).extend(some)
    ordered = {name: np.sort(some) for name, some in of.items()}
    return {
        name: at[some[np.diff(commands.stamps[some], prepend=-np.inf) != 0.0]]
        for name, some in ordered.items()
    }


def _seen(grid: TickGrid, frames: Topic, true_pos: Array) -> NDArray[np.bool_]:
    """Return which vehicles were observed, (T, n), also under each other's names.

    After a clock jump several frames may have the same stamp; each of them counts.
    """
    seen = np.zeros(true_pos.shape[:2], dtype=np.bool_)
    while (table := Table(grid, frames)).last.any():
        samples = table.column("pos", 3)
        seen |= np.isfinite(samples).all(axis=2) | near_sample(true_pos, samples, SIGHT_M)
        frames = Topic([frames.signals[k] for k in np.flatnonzero(~table.last).tolist()])
    return seen
