"""Evidence for the policies: the signals of a flight in arrays, tick by tick.

Rows are ticks, with the stamps of `truth` if recorded, else of the first topic of the data flow that is. A
signal belongs to the tick with its stamp; of several, the last counts. Missing values are NaN.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from q2q_model.signals.layout import Signal
from q2q_model.signals.values import Array, MocapFrame, Names, index_of

NAMING = ("truth", "reference", "reference_safe", "state", "command", "mocap")
"""Topics that give ticks and names, in order of preference."""
SIGHT_M = 0.1
"""A sample within this distance observes the vehicle, whatever its name [m]: the paper's eps."""
SAME_TICK = 1e-4
"""Stamps closer than this are the same tick [s]: a hundredth of a tick."""


@dataclass(frozen=True, slots=True)
class RecordedSignal:
    """One message of a flight."""

    topic: str
    """Without a leading slash."""
    at: float
    """Time of recording [s]; in lockstep the stamp."""
    signal: Signal


@dataclass(frozen=True, slots=True)
class Evidence:
    """Flight of T ticks and n vehicles."""

    t: Array
    """Stamps of the ticks [s], rising, (T,)."""
    names: Names
    true_pos: Array
    """[m], (T, n, 3)."""
    sent_pos: Array
    """Setpoints of the controller: reference_safe, else reference [m], (T, n, 3)."""
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
    commanded_at: Array
    """Time of recording of each new command [s], (K,)."""
    live: bool
    """Bag time is wall time, so that gaps count."""
    not_finite: tuple[str, ...]
    """Signals with numbers that are not finite, one line for each topic."""

    @property
    def tick(self) -> float:
        """Return the time between ticks [s]."""
        return float(np.median(np.diff(self.t))) if len(self.t) > 1 else 0.01


def evidence_of(recorded: Iterable[RecordedSignal]) -> Evidence:
    """Return the evidence from a flight's messages.

    Raises:
        ValueError: no message names vehicles and ticks.
    """
    by_topic: dict[str, list[RecordedSignal]] = {}
    for one in recorded:
        by_topic.setdefault(one.topic, []).append(one)
    signals = {topic: [one.signal for one in found] for topic, found in by_topic.items()}
    naming = next((signals[topic] for topic in NAMING if signals.get(topic)), None)
    if naming is None:
        raise ValueError(f"no ticks: a flight needs one of {', '.join(NAMING)}")
    names = tuple(dict.fromkeys(name for signal in naming for name in signal.names))
    table = _Table(np.unique([signal.t for signal in naming]), names)
    sent = signals.get("reference_safe") or signals.get("reference", [])
    states, commands = signals.get("state", []), signals.get("command", [])
    timed_commands = by_topic.get("command", [])
    true_pos = table.column(signals.get("truth", []), "pos", 3)
    return Evidence(
        t=table.t,
        names=names,
        true_pos=true_pos,
        sent_pos=table.column(sent, "pos", 3),
        seen=_seen(table, signals.get("mocap", []), true_pos),
        state_pos=table.column(states, "pos", 3),
        state_age=table.column(states, "age", 1),
        state_status=table.column(states, "status", 1),
        thrust=table.column(commands, "thrust", 1),
        roll=table.column(commands, "roll", 1),
        pitch=table.column(commands, "pitch", 1),
        command_status=table.column(commands, "status", 1),
        commanded_at=np.array([one.at for one in timed_commands]),
        live=any(abs(one.at - one.signal.t) > SAME_TICK for one in timed_commands),
        not_finite=tuple(filter(None, (_first_not_finite(topic, found) for topic, found in signals.items()))),
    )


def _seen(table: "_Table", frames: Sequence[Signal], true_pos: Array) -> NDArray[np.bool_]:
    """Return which vehicles were observed, (T, n), also under each other's names.

    After a clock jump several frames may have the same stamp; each of them counts.
    """
    seen = np.zeros(true_pos.shape[:2], dtype=np.bool_)
    while last := set(table.last(frames).values()):
        samples = table.column(frames, "pos", 3)
        apart = np.linalg.norm(samples[:, None] - true_pos[:, :, None], axis=3)  # (T, vehicle, sample)
        seen |= np.isfinite(samples).all(axis=2) | (apart < SIGHT_M).any(axis=2)
        frames = [frame for k, frame in enumerate(frames) if k not in last]
    return seen


class _Table:
    """Ticks and vehicles of the rows and columns."""

    def __init__(self, t: Array, names: Names) -> None:
        self.t, self._names = t, names

    def column(self, signals: Sequence[Signal], attribute: str, width: int) -> Array:
        """Return one attribute of a topic, (T, n) or (T, n, width); NaN where missing."""
        shape = (len(self.t), len(self._names), width)
        made = np.full(shape if width > 1 else shape[:2], np.nan)
        row_of = {k: row for row, k in self.last(signals).items()}
        for names, some in _by_names(signals, row_of).items():
            at = index_of(names, self._names)
            values = np.stack([getattr(signals[k], attribute) for k in some])
            rows = np.array([row_of[k] for k in some])
            made[np.ix_(rows, at[at >= 0])] = values[:, at >= 0]
        return made

    def last(self, signals: Sequence[Signal]) -> dict[int, int]:
        """Return the last signal of each row that has one."""
        stamps = np.array([signal.t for signal in signals])
        rows = np.clip(np.searchsorted(self.t, stamps - SAME_TICK), 0, len(self.t) - 1)
        mine = np.abs(self.t[rows] - stamps) <= SAME_TICK
        return dict(zip(rows[mine].tolist(), np.flatnonzero(mine).tolist(), strict=True))


def _by_names(signals: Sequence[Signal], chosen: Iterable[int]) -> dict[Names, list[int]]:
    """Return groups of the chosen signals with the same names in the same order."""
    found: dict[Names, list[int]] = {}
    for k in chosen:
        found.setdefault(signals[k].names, []).append(k)
    return found


_MAY_BE_NAN = {"std"}
"""Attributes in which NaN means unknown."""
_MAY_BE_INFINITE = {"age"}
"""Attributes in which infinity means never."""


def _first_not_finite(topic: str, signals: Sequence[Signal]) -> str:
    """Return the first value of a topic that is not finite, else nothing; frames may have NaN."""
    if not signals or isinstance(signals[0], MocapFrame):
        return ""
    for attribute in signals[0].__dataclass_fields__:
        if attribute in _MAY_BE_NAN or not isinstance(getattr(signals[0], attribute), np.ndarray):
            continue
        lost = np.isnan if attribute in _MAY_BE_INFINITE else _not_finite
        if lost(np.concatenate([getattr(signal, attribute) for signal in signals])).any():
            first = next(signal for signal in signals if lost(getattr(signal, attribute)).any())
            return f"{topic} at {first.t:.3f} s: {attribute} is not finite"
    return ""


def _not_finite(values: Array) -> NDArray[np.bool_]:
    return ~np.isfinite(values)
