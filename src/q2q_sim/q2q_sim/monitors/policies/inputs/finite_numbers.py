"""Numbers of a flight that are not finite, apart from those that its table lacks.

A table that bag_import made a bag of has no yaw rate, for one: it is NaN throughout, and so may be all that
was not logged of a vehicle. A node that sends NaN throughout is broken.
"""

from collections.abc import Mapping

import numpy as np

from q2q_model.flights.tables.table_signals import LACKED
from q2q_model.signals.values import Array, Mask, MocapFrame
from q2q_sim.monitors.policies.inputs.signal_tables import Topic

_OF_TABLES = frozenset({"mocap", "state", "reference", "command", "imu"})
"""Topics of a bag that was a table."""
_REFUSED = {"age": np.isnan, "std": np.isinf, "quat": np.isinf}
"""Tests for values that are refused, of attributes in which another value that is not finite has a meaning:
an age that is infinite means never, a deviation that is NaN unknown, an attitude that is NaN none yet."""


def first_not_finite(topics: Mapping[str, Topic], *, live: bool) -> tuple[str, ...]:
    """Return the first value of each topic that is not finite, in a sentence; frames may have NaN."""
    tabular = not live and _was_table(topics)
    return tuple(filter(None, (_first(name, topic, tabular=tabular) for name, topic in topics.items())))


def _was_table(topics: Mapping[str, Topic]) -> bool:
    """Return whether topics are those of an imported table: no others, without what no table has.

    Commands without any number, and no references, are as well those of a broken controller in lockstep.
    """
    present = {name: topic for name, topic in topics.items() if topic.signals}
    if "command" in present and "reference" not in present and _is_nan(present["command"], "thrust"):
        return False
    return present.keys() <= _OF_TABLES and all(
        _is_nan(present[name], attribute)
        for name, attributes in LACKED.items()
        if name in present
        for attribute in attributes
    )


def _is_nan(topic: Topic, attribute: str) -> bool:
    """Return whether an attribute is NaN throughout."""
    return all(np.isnan(values).all() for values in topic.values(attribute).values())


def _first(name: str, topic: Topic, *, tabular: bool) -> str:
    """Return the first value that is not finite; columns of a table may be NaN throughout."""
    signals = topic.signals
    if not signals or isinstance(signals[0], MocapFrame):
        return ""
    for attribute in signals[0].__dataclass_fields__:
        one = getattr(signals[0], attribute)
        if not (isinstance(one, np.ndarray) and one.dtype.kind == "f"):
            continue
        places = [
            topic.by_names[names][int(wrong.argmax())]
            for names, values in topic.values(attribute).items()
            if (wrong := _wrong_rows(attribute, values, tabular=tabular)).any()
        ]
        if places:
            return f"{name} at {signals[min(places)].t:.3f} s: {attribute} is not finite"
    return ""


def _wrong_rows(attribute: str, values: Array, *, tabular: bool) -> Mask:
    """Return which signals have a value that is not finite, (k,), of an attribute (k, n, ...).

    Of a table, what is NaN throughout for a vehicle is a column that it lacks.
    """
    wrong = _REFUSED.get(attribute, _not_finite)(values)
    if tabular:
        wrong &= ~np.isnan(values).all(axis=0)
    return np.asarray(wrong.reshape(len(wrong), -1).any(axis=1))


def _not_finite(values: Array) -> Mask:
    return ~np.isfinite(values)
