"""A flight joined from its signals by their stamps, with remarks on what was corrected."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from q2q_model.counted import counted
from q2q_model.flights.flight import FIELD_WIDTHS, FLIGHT_FIELDS, Flight
from q2q_model.flights.flight_ticks import flight_ticks
from q2q_model.flights.output_ticks import OUTPUTS, output_ticks
from q2q_model.signals.layout import Signal
from q2q_model.signals.rows import SignalRows, rows_of_signals
from q2q_model.signals.stamps import STALLED
from q2q_model.signals.values import Array, Names, index_of

FREE_RUNNING = "command"
"""Topic that may outlast the ticks: a live controller publishes by its own clock."""

_NAME_SOURCES = ("truth", "reference", "state", "command", "reference_safe", "interference", "imu", "mocap")
"""Topics in the order in which vehicle names are taken from them; those with the whole swarm first."""

_CLOCKS = ("truth", "mocap")
"""Topics with the times of the ticks, and the stamps of the frames."""


@dataclass(frozen=True, slots=True)
class JoinedFlight:
    """Flight joined from signals, and the corrections made."""

    flight: Flight
    repairs: tuple[str, ...]


def flight_from_signals(name: str, signals: Mapping[str, Sequence[Signal]]) -> JoinedFlight:
    """Return a flight of signals joined by their stamps; see `flight_from_rows`."""
    return flight_from_rows(name, {topic: rows_of_signals(found) for topic, found in signals.items()})


def flight_from_rows(name: str, signals: Mapping[str, Sequence[SignalRows]]) -> JoinedFlight:
    """Return a flight of signals joined by their stamps.

    Args:
        name: name of the flight.
        signals: topic of FLIGHT_FIELDS -> its signals, in any order. The stamps of the first topic with
            signals (truth, then mocap) are the ticks; see flight_ticks for a truth that does not cover the
            frames, and output_ticks for frames with other stamps.

    Raises:
        ValueError: there is no signal, no stamp of a topic is a tick (the clocks are mixed), or all ticks
            have one stamp.
    """
    present = {topic: signals[topic] for topic in FLIGHT_FIELDS if signals.get(topic)}
    if not present:
        raise ValueError(f"no signal found; a flight needs one of {', '.join(FLIGHT_FIELDS)}")
    names = tuple(
        dict.fromkeys(vehicle for topic in _NAME_SOURCES for vehicle in _names_in(present.get(topic, ())))
    )
    ticks_of, t = _ticks(present)
    arrays = {
        field: np.full((len(t), len(names), width)[: 2 if width == 1 else 3], np.nan)
        for field, width in FIELD_WIDTHS.items()
    }
    repairs: list[str] = []
    for topic, recorded in present.items():
        found = _at_ticks(recorded, present) if topic in OUTPUTS else recorded
        repairs += _remarks(topic, found, t, ticks_of)
        for rows in found:
            _fill(arrays, topic, rows, (t, names))
    return JoinedFlight(Flight(name=name, names=names, t=t, **arrays), tuple(repairs))


def _ticks(present: Mapping[str, Sequence[SignalRows]]) -> tuple[str, Array]:
    """Return the topic of the ticks, and the ticks [s], rising, (T,)."""
    first = next(iter(present))
    check_clock(first, stamps := _stamps(present[first]))
    if not {"truth", "mocap"} <= set(present):
        return first, np.unique(stamps)
    t = flight_ticks(stamps, _stamps(present["mocap"]))
    return ("truth" if np.isin(stamps, t).all() else "mocap"), t


def check_clock(topic: str, stamps: Array) -> None:
    """Raise ValueError if all of STALLED or more stamps (m,) [s] are the same."""
    if len(stamps) >= STALLED and stamps.min() == stamps.max():
        raise ValueError(
            f"all {len(stamps)} messages on {topic} are stamped {stamps[0]:g} s: stamp each with its time of "
            "capture, or read poses by a topic map with `stamps: receive`"
        )


def _names_in(found: Sequence[SignalRows]) -> dict[str, None]:
    """Return the vehicles in the order of the recording."""
    groups = sorted(found, key=lambda rows: int(rows.place[0]))
    return dict.fromkeys(vehicle for rows in groups for vehicle in rows.names)


def _stamps(found: Sequence[SignalRows]) -> Array:
    """Return the stamps of all rows in the order of the recording."""
    stamps = np.concatenate([rows.t for rows in found])
    return stamps[np.argsort(np.concatenate([rows.place for rows in found]))]


def _at_ticks(outputs: Sequence[SignalRows], present: Mapping[str, Sequence[SignalRows]]) -> list[SignalRows]:
    """Return the rows of a topic of outputs, stamped with the ticks of their frames."""
    truth, frames = (_stamps(present[topic]) if topic in present else np.zeros(0) for topic in _CLOCKS)
    made = []
    for rows in outputs:
        of_node = [one for one in outputs if set(one.names) & set(rows.names)]
        ticks = output_ticks(truth, frames, _stamps(of_node))
        order = np.sort(np.concatenate([one.place for one in of_node]))
        made.append(replace(rows, t=ticks[np.searchsorted(order, rows.place)]))
    return made


def _remarks(topic: str, found: Sequence[SignalRows], t: Array, ticks_of: str) -> list[str]:
    stamps = _stamps(found)
    unmatched = int(np.count_nonzero(~np.isin(stamps, t)))
    if unmatched == len(stamps):
        raise ValueError(
            f"no stamp of {topic} ({stamps.min():.3f} to {stamps.max():.3f} s) is one of {ticks_of} "
            f"({t[0]:.3f} to {t[-1]:.3f} s): the clocks are mixed, or the recordings do not overlap"
        )
    remarks = []
    if topic == FREE_RUNNING:
        unmatched -= int(np.count_nonzero(stamps > t[-1]))
    if unmatched:
        remarks.append(
            f"{unmatched} of {len(stamps)} messages on {topic} match no tick of {ticks_of}: dropped"
        )
    repeated = _repeated(found)
    if repeated:
        remarks.append(f"{counted(repeated, 'repeated stamp')} on {topic}: the last message is used")
    if any(np.any(np.diff(rows.t) < 0.0) for rows in found):  # each of one node
        remarks.append(f"stamps on {topic} are out of order: sorted by time")
    return remarks


def _repeated(found: Sequence[SignalRows]) -> int:
    """Return the number of repeated stamps, of the vehicle with most: controllers may send a part each."""
    stamps: dict[str, list[Array]] = {}
    for rows in found:
        for vehicle in rows.names:
            stamps.setdefault(vehicle, []).append(rows.t)
    each = [np.concatenate(parts) for parts in stamps.values()]
    return max((len(one) - len(np.unique(one)) for one in each), default=0)


def _fill(arrays: dict[str, Array], topic: str, rows: SignalRows, axes: tuple[Array, Names]) -> None:
    t, names = axes
    known = np.isin(rows.t, t)
    ticks = np.searchsorted(t, rows.t[known])
    columns = index_of(rows.names, names)
    for attribute, field in FLIGHT_FIELDS[topic].items():
        arrays[field][ticks[:, None], columns] = rows.values[attribute][known]
