"""Rows of signals (q2q_model.signals.rows), decoded from message bytes in bulk.

Messages of equal length that differ only in stamp and numbers have the same names at the same offsets.
cdr_reader decodes and checks the first; the numbers of all are sliced from one byte matrix.
Remaining messages are decoded one by one.
"""

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from q2q_model.signals.cdr.cdr_format import NAMES_AT, START
from q2q_model.signals.cdr.cdr_reader import SignalReader
from q2q_model.signals.layout import LAYOUTS, Signal
from q2q_model.signals.rows import SignalRows, rows_of_signals
from q2q_model.signals.stamps import END_S, NANOSECONDS
from q2q_model.signals.values import Mask, Rows

MOST_KINDS = 8
"""Most name sets of one message length; a recording with more is decoded message by message."""


def rows_of_messages(messages: Sequence[bytes], kind: type[Signal]) -> list[SignalRows]:
    """Return the rows of serialized messages of one type.

    Raises:
        BadMessageError: a malformed message.
    """
    lengths: dict[int, list[int]] = {}
    for place, message in enumerate(messages):
        lengths.setdefault(len(message), []).append(place)
    return [rows for places in lengths.values() for rows in _of_one_length(messages, np.array(places), kind)]


def _of_one_length(messages: Sequence[bytes], places: Rows, kind: type[Signal]) -> Iterator[SignalRows]:
    for _ in range(MOST_KINDS):
        if places.size < 2:
            break
        table = np.frombuffer(b"".join(messages[place] for place in places), np.uint8)
        table = table.reshape(places.size, -1)
        rows, alike = _like_first(table, messages[places[0]], kind)
        yield _placed(rows, places[alike])
        places = places[~alike]
    if places.size:
        reader: SignalReader[Signal] = SignalReader(kind)
        yield from rows_of_signals([reader.read(messages[place]) for place in places], places.tolist())


def _placed(rows: SignalRows, place: Rows) -> SignalRows:
    return SignalRows(rows.names, rows.t, rows.values, place)


def _like_first(table: NDArray[np.uint8], first: bytes, kind: type[Signal]) -> tuple[SignalRows, Mask]:
    """Return the rows with the first message's layout, and the mask of these in the table."""
    signal = SignalReader[Signal](kind).read(first)
    arrays = {column.attribute: getattr(signal, column.attribute) for column in LAYOUTS[kind].columns}
    begin = np.frombuffer(first, np.uint8).ctypes.data
    spans = {
        name: slice(at, at + one.nbytes)
        for name, one in arrays.items()
        if one.size and (at := one.ctypes.data - begin) >= 0  # the reader's arrays are views of the bytes
    }
    fixed = np.ones(table.shape[1], dtype=np.bool_)
    fixed[START:NAMES_AT] = False
    for span in spans.values():
        fixed[span] = False
    sec, nanosec = _stamps(table)
    allowed = (np.abs(sec) < END_S) & (nanosec < NANOSECONDS)  # others are refused one by one
    alike = np.asarray((table[:, fixed] == table[0, fixed]).all(axis=1) & allowed)
    chosen, t = table[alike], (sec * NANOSECONDS + nanosec)[alike] * 1e-9  # rounded as by time_from_stamp
    values = {
        name: np.ascontiguousarray(chosen[:, spans[name]]).view(one.dtype).reshape(-1, *one.shape)
        if name in spans
        else np.zeros((chosen.shape[0], *one.shape), one.dtype)
        for name, one in arrays.items()
    }
    return SignalRows(signal.names, t, values, np.nonzero(alike)[0]), alike


def _stamps(table: NDArray[np.uint8]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return sec and nanosec of messages."""
    words = np.ascontiguousarray(table[:, START:NAMES_AT])
    return words.view("<i4")[:, 0].astype(np.int64), words.view("<u4")[:, 1].astype(np.int64)
