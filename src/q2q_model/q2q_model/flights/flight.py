"""A recorded flight as arrays over time.

T ticks, n vehicles; NaN where nothing was recorded. Frames and units are those of q2q_model.signals.values.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from q2q_model.counted import counted
from q2q_model.flights.answer_ticks import ANSWERS, answer_ticks
from q2q_model.flights.flight_ticks import flight_ticks
from q2q_model.signals.layout import LAYOUTS, Signal
from q2q_model.signals.rows import SignalRows, rows_of_signals
from q2q_model.signals.values import Array, Names, index_of


@dataclass(frozen=True, slots=True)
class Flight:
    """Record of one flight, one row per tick."""

    name: str
    names: Names
    t: Array
    """Capture stamps [s], rising, (T,)."""
    mocap_pos: Array
    """Motion capture position [m], (T, n, 3); NaN where a vehicle was not in the frame."""
    mocap_quat: Array
    """(T, n, 4)"""
    pos: Array
    """Filtered position [m], (T, n, 3)."""
    vel: Array
    """Filtered velocity [m/s], (T, n, 3)."""
    quat: Array
    """Filtered orientation x y z w, (T, n, 4)."""
    true_pos: Array
    """True position [m], (T, n, 3); NaN outside a simulator."""
    true_vel: Array
    """True velocity [m/s], (T, n, 3)."""
    true_eta: Array
    """True downwash acceleration [m/s^2], (T, n, 3)."""
    ref_pos: Array
    """Planned position [m], (T, n, 3)."""
    ref_vel: Array
    """Planned velocity [m/s], (T, n, 3)."""
    ref_acc: Array
    """Planned acceleration [m/s^2], (T, n, 3)."""
    safe_pos: Array
    """Position setpoint of the controller [m], (T, n, 3); replanned where a replanner ran."""
    safe_vel: Array
    """Velocity setpoint of the controller [m/s], (T, n, 3)."""
    safe_acc: Array
    """Acceleration setpoint of the controller [m/s^2], (T, n, 3)."""
    eta: Array
    """Predicted downwash acceleration [m/s^2], (T, n, 3)."""
    thrust: Array
    """Commanded collective thrust U1 [N], (T, n)."""
    roll: Array
    """Commanded phi [rad], (T, n)."""
    pitch: Array
    """Commanded theta [rad], (T, n)."""
    command_status: Array
    """CommandStatus as float, (T, n); NaN without a command."""
    specific_force_body: Array
    """Accelerometer [m/s^2], body, (T, n, 3)."""
    gyro_body: Array
    """Gyroscope [rad/s], body, (T, n, 3)."""


FLIGHT_FIELDS: dict[str, dict[str, str]] = {
    "truth": {"pos": "true_pos", "vel": "true_vel"},
    "mocap": {"pos": "mocap_pos", "quat": "mocap_quat"},
    "reference": {"pos": "ref_pos", "vel": "ref_vel", "acc": "ref_acc"},
    "state": {"pos": "pos", "vel": "vel", "quat": "quat"},
    "truth_interference": {"acc": "true_eta"},
    "reference_safe": {"pos": "safe_pos", "vel": "safe_vel", "acc": "safe_acc"},
    "interference": {"acc": "eta"},
    "command": {"thrust": "thrust", "roll": "roll", "pitch": "pitch", "status": "command_status"},
    "imu": {"specific_force_body": "specific_force_body", "ang_vel_body": "gyro_body"},
}
"""Topic -> attribute of its signal -> field of Flight. The first topic present defines the ticks; see
flight_ticks for a truth that does not cover the frames."""

_WIDTHS = {
    field: column.width
    for fields in FLIGHT_FIELDS.values()
    for attribute, field in fields.items()
    for layout in LAYOUTS.values()
    for column in layout.columns
    if column.attribute == attribute
}


@dataclass(frozen=True, slots=True)
class JoinedFlight:
    """Flight joined from signals, and the corrections made."""

    flight: Flight
    repairs: tuple[str, ...]


def of_vehicle(flight: Flight, name: str) -> Flight:
    """Return the flight of one vehicle, in views of the arrays.

    Raises:
        ValueError: the vehicle is not in the flight.
    """
    row = flight.names.index(name)
    made = {field: getattr(flight, field)[:, row : row + 1] for field in _WIDTHS}
    return replace(flight, names=(name,), **made)


def of_vehicles(flight: Flight, names: Names) -> Flight:
    """Return the flight of some vehicles.

    Raises:
        ValueError: a vehicle is not in the flight.
    """
    rows = [flight.names.index(name) for name in names]
    made = {field: getattr(flight, field)[:, rows] for field in _WIDTHS}
    return replace(flight, names=names, **made)


def of_rows(flight: Flight, rows: slice) -> Flight:
    """Return some ticks of a flight, in views of the arrays."""
    made = {field: getattr(flight, field)[rows] for field in _WIDTHS}
    return replace(flight, t=flight.t[rows], **made)


def flight_from_signals(name: str, signals: Mapping[str, Sequence[Signal]]) -> JoinedFlight:
    """Return a flight of signals joined by their stamps; see `flight_from_rows`."""
    return flight_from_rows(name, {topic: rows_of_signals(found) for topic, found in signals.items()})


def flight_from_rows(name: str, signals: Mapping[str, Sequence[SignalRows]]) -> JoinedFlight:
    """Return a flight of signals joined by their stamps.

    Args:
        name: name of the flight.
        signals: topic of FLIGHT_FIELDS -> its signals, in any order. The stamps of the first topic with
            signals (truth, then mocap) are the ticks; see flight_ticks for a truth that does not cover the
            frames, and answer_ticks for frames with other stamps.

    Raises:
        ValueError: there is no signal, no stamp of a topic is a tick (the clocks are mixed), or all ticks
            have one stamp.
    """
    present = {topic: signals[topic] for topic in FLIGHT_FIELDS if signals.get(topic)}
    if not present:
        raise ValueError(f"there is no signal; a flight needs one of {', '.join(FLIGHT_FIELDS)}")
    names = tuple(
        dict.fromkeys(vehicle for topic in _NAME_SOURCES for vehicle in _names_in(present.get(topic, ())))
    )
    ticks_of, t = _ticks(present)
    arrays = {
        field: np.full((len(t), len(names), width)[: 2 if width == 1 else 3], np.nan)
        for field, width in _WIDTHS.items()
    }
    repairs: list[str] = []
    for topic, recorded in present.items():
        found = _at_ticks(recorded, present) if topic in ANSWERS else recorded
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


STALLED = 100
"""Messages with one stamp from which their clock is stalled; a lost one is sent again a few times."""


def check_clock(topic: str, stamps: Array) -> None:
    """Raise ValueError if STALLED messages or more have one and the same stamp: no flight is in them."""
    if len(stamps) >= STALLED and stamps.min() == stamps.max():
        raise ValueError(
            f"all {len(stamps)} messages on {topic} are stamped {stamps[0]:g} s: stamp each with its time of "
            "capture, or read poses by a topic map with `stamps: receive`"
        )


_NAME_SOURCES = ("truth", "reference", "state", "command", "reference_safe", "interference", "imu", "mocap")
"""Topics in the order in which vehicle names are taken from them; those with the whole swarm first."""

FREE_RUNNING = "command"
"""Topic that may outlast the ticks: a live controller publishes by its own clock."""


def _names_in(found: Sequence[SignalRows]) -> dict[str, None]:
    """Return the vehicles in the order of the recording."""
    groups = sorted(found, key=lambda rows: int(rows.place[0]))
    return dict.fromkeys(vehicle for rows in groups for vehicle in rows.names)


def _stamps(found: Sequence[SignalRows]) -> Array:
    """Return the stamps of all rows in the order of the recording."""
    stamps = np.concatenate([rows.t for rows in found])
    return stamps[np.argsort(np.concatenate([rows.place for rows in found]))]


def _at_ticks(answers: Sequence[SignalRows], present: Mapping[str, Sequence[SignalRows]]) -> list[SignalRows]:
    """Return the rows of a topic of answers, stamped with the ticks of their frames."""
    truth, frames = (_stamps(present[topic]) if topic in present else np.zeros(0) for topic in _CLOCKS)
    made = []
    for rows in answers:
        of_node = [one for one in answers if set(one.names) & set(rows.names)]
        ticks = answer_ticks(truth, frames, _stamps(of_node))
        order = np.sort(np.concatenate([one.place for one in of_node]))
        made.append(replace(rows, t=ticks[np.searchsorted(order, rows.place)]))
    return made


_CLOCKS = ("truth", "mocap")
"""Topics with the times of the ticks, and the stamps of the frames."""


def _repeated(found: Sequence[SignalRows]) -> int:
    """Return the number of repeated stamps, of the vehicle with most: controllers may send a part each."""
    stamps: dict[str, list[Array]] = {}
    for rows in found:
        for vehicle in rows.names:
            stamps.setdefault(vehicle, []).append(rows.t)
    each = [np.concatenate(parts) for parts in stamps.values()]
    return max((len(one) - len(np.unique(one)) for one in each), default=0)


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
        remarks.append(f"stamps on {topic} are out of order: sorted")
    return remarks


def _fill(arrays: dict[str, Array], topic: str, rows: SignalRows, axes: tuple[Array, Names]) -> None:
    t, names = axes
    known = np.isin(rows.t, t)
    ticks = np.searchsorted(t, rows.t[known])
    columns = index_of(rows.names, names)
    for attribute, field in FLIGHT_FIELDS[topic].items():
        arrays[field][ticks[:, None], columns] = rows.values[attribute][known]
