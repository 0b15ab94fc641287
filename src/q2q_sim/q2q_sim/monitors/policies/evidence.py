"""Evidence for the policies: the signals of a flight in arrays, tick by tick.

Rows are ticks, with the stamps of `truth` if recorded, else of the first topic of the data flow that is. A
signal belongs to the tick with its stamp; of several, the last counts. Missing values are NaN.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from operator import attrgetter
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from q2q_model.signals.layout import Signal
from q2q_model.signals.values import Array, MocapFrame, Names, index_of
from q2q_sim.monitors.proximity import near_sample

Rows = NDArray[np.intp]

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
    true_downwash: Array = field(default_factory=lambda: np.full((1, 1, 3), np.nan))
    """True acceleration by the downwash [m/s^2], (T, n, 3); (1, 1, 3) if unknown."""

    @property
    def tick(self) -> float:
        """Return the time between ticks [s]."""
        return float(np.median(np.diff(self.t))) if len(self.t) > 1 else 0.01


def evidence_of(recorded: Iterable[RecordedSignal]) -> Evidence:
    """Return the evidence from a flight's messages.

    Raises:
        ValueError: no message names vehicles and ticks.
    """
    signals: dict[str, list[Signal]] = {}
    commanded_at = []
    for one in recorded:
        signals.setdefault(one.topic, []).append(one.signal)
        if one.topic == "command":
            commanded_at.append(one.at)
    return _evidence(signals, np.array(commanded_at))


def evidence_in_lockstep(signals: Mapping[str, Sequence[Signal]]) -> Evidence:
    """Return the evidence from a flight's signals by topic, recorded at their own stamps.

    Raises:
        ValueError: no signal names vehicles and ticks.
    """
    return _evidence(signals, _stamps(signals.get("command", [])))


def _evidence(signals: Mapping[str, Sequence[Signal]], commanded_at: Array) -> Evidence:
    """Return the evidence from signals by topic and the times of recording of the commands [s], (K,)."""
    naming = next((signals[topic] for topic in NAMING if signals.get(topic)), None)
    if naming is None:
        raise ValueError(f"no ticks: a flight needs one of {', '.join(NAMING)}")
    names = tuple(dict.fromkeys(name for signal in naming for name in signal.names))
    grid = _Grid(np.unique(_stamps(naming)), names)
    states, commands = _Table(grid, signals.get("state", [])), _Table(grid, signals.get("command", []))
    command_stamps = _stamps(signals.get("command", []))
    true_pos = _Table(grid, signals.get("truth", [])).column("pos", 3)
    sent = _Table(grid, signals.get("reference_safe") or signals.get("reference", []))
    return Evidence(
        t=grid.t,
        names=names,
        true_pos=true_pos,
        sent_pos=sent.column("pos", 3),
        seen=_seen(grid, signals.get("mocap", []), true_pos),
        state_pos=states.column("pos", 3),
        state_age=states.column("age", 1),
        state_status=states.column("status", 1),
        thrust=commands.column("thrust", 1),
        roll=commands.column("roll", 1),
        pitch=commands.column("pitch", 1),
        command_status=commands.column("status", 1),
        commanded_at=commanded_at,
        live=bool((np.abs(commanded_at - command_stamps) > SAME_TICK).any()),
        not_finite=tuple(filter(None, (_first_not_finite(topic, found) for topic, found in signals.items()))),
        true_downwash=_Table(grid, signals.get("truth_interference", [])).column("acc", 3),
    )


def _stamps(signals: Sequence[Signal]) -> Array:
    return np.array([one.t for one in signals], dtype=np.float64)


def _seen(grid: "_Grid", frames: Sequence[Signal], true_pos: Array) -> NDArray[np.bool_]:
    """Return which vehicles were observed, (T, n), also under each other's names.

    After a clock jump several frames may have the same stamp; each of them counts.
    """
    seen = np.zeros(true_pos.shape[:2], dtype=np.bool_)
    while (table := _Table(grid, frames)).last:
        samples = table.column("pos", 3)
        seen |= np.isfinite(samples).all(axis=2) | near_sample(true_pos, samples, SIGHT_M)
        frames = [frame for k, frame in enumerate(frames) if k not in table.last]
    return seen


class _Grid(NamedTuple):
    """Ticks of the rows and vehicles of the columns."""

    t: Array
    names: Names


class _Group(NamedTuple):
    """Signals with the same names in the same order."""

    signals: list[Signal]
    place: tuple[Rows, ...]
    """Their rows and columns, for an array of the grid."""
    known: NDArray[np.bool_]
    """Which of their vehicles are in the grid."""


class _Table:
    """Signals of a topic in the rows and columns of a grid."""

    def __init__(self, grid: _Grid, signals: Sequence[Signal]) -> None:
        self._shape = len(grid.t), len(grid.names)
        rows = _last_of_rows(grid.t, signals)
        self.last = rows.keys()
        """The last signal of each row that has one."""
        self._groups: list[_Group] = []
        for names, some in _by_names(signals, rows).items():
            at = index_of(names, grid.names)
            place = np.ix_(np.array([rows[k] for k in some]), at[at >= 0])
            self._groups.append(_Group([signals[k] for k in some], place, at >= 0))

    def column(self, attribute: str, width: int) -> Array:
        """Return one attribute, (T, n) or (T, n, width); NaN where missing."""
        made = np.full((*self._shape, width) if width > 1 else self._shape, np.nan)
        for signals, place, known in self._groups:
            rows = list(map(attrgetter(attribute), signals))
            values = np.concatenate(rows).reshape(len(rows), *rows[0].shape)
            made[place] = values[:, known]
        return made


def _last_of_rows(t: Array, signals: Sequence[Signal]) -> dict[int, int]:
    """Return the row of each signal that is the last of its row."""
    stamps = _stamps(signals)
    rows = np.clip(np.searchsorted(t, stamps - SAME_TICK), 0, len(t) - 1)
    mine = np.abs(t[rows] - stamps) <= SAME_TICK
    last = dict(zip(rows[mine].tolist(), np.flatnonzero(mine).tolist(), strict=True))
    return {k: row for row, k in last.items()}


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
        one = getattr(signals[0], attribute)
        if attribute in _MAY_BE_NAN or not (isinstance(one, np.ndarray) and one.dtype.kind == "f"):
            continue
        lost = np.isnan if attribute in _MAY_BE_INFINITE else _not_finite
        if lost(np.concatenate(list(map(attrgetter(attribute), signals)))).any():
            first = next(signal for signal in signals if lost(getattr(signal, attribute)).any())
            return f"{topic} at {first.t:.3f} s: {attribute} is not finite"
    return ""


def _not_finite(values: Array) -> NDArray[np.bool_]:
    return ~np.isfinite(values)
