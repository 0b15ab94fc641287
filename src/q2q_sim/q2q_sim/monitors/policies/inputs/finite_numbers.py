"""Numbers of a flight that are not finite, apart from those that its table lacks.

A table that bag_import made a bag of has no yaw rate, for one: it is NaN throughout. A node that sends NaN
throughout is broken.
"""

from collections.abc import Collection, Mapping

import numpy as np
from numpy.typing import NDArray

from q2q_model.flights.tables.table_signals import LACKED, MAY_LACK
from q2q_model.signals.values import Array, MocapFrame
from q2q_sim.monitors.policies.inputs.signal_tables import Topic

_OF_TABLES = frozenset({"mocap", "state", "reference", "command", "imu"})
"""Topics of a bag that was a table."""
_REFUSED = {"age": np.isnan, "std": np.isinf, "quat": np.isinf}
"""Tests for values that are refused, of attributes in which another value that is not finite has a meaning:
an age that is infinite means never, a deviation that is NaN unknown, an attitude that is NaN none yet."""


def first_not_finite(topics: Mapping[str, Topic], *, live: bool) -> tuple[str, ...]:
    """Return the first value of each topic that is not finite, in a sentence; frames may have NaN."""
    tabular = not live and _was_table(topics)
    lacking = {
        name: {*LACKED.get(name, ()), *MAY_LACK.get(name, ())} if tabular else set() for name in topics
    }
    return tuple(filter(None, (_first(name, topic, lacking[name]) for name, topic in topics.items())))


def _was_table(topics: Mapping[str, Topic]) -> bool:
    """Return whether topics are those of an imported table: no others, without what no table has."""
    present = {name: topic for name, topic in topics.items() if topic.signals}
    return present.keys() <= _OF_TABLES and all(
        _is_nan(present[name], attribute)
        for name, attributes in LACKED.items()
        if name in present
        for attribute in attributes
    )


def _is_nan(topic: Topic, attribute: str) -> bool:
    """Return whether an attribute is NaN throughout."""
    return all(np.isnan(values).all() for values in topic.values(attribute).values())


def _first(name: str, topic: Topic, lacking: Collection[str]) -> str:
    """Return the first value that is not finite; attributes of `lacking` may be NaN throughout."""
    signals = topic.signals
    if not signals or isinstance(signals[0], MocapFrame):
        return ""
    for attribute in signals[0].__dataclass_fields__:
        one = getattr(signals[0], attribute)
        if not (isinstance(one, np.ndarray) and one.dtype.kind == "f"):
            continue
        if attribute in lacking and _is_nan(topic, attribute):
            continue
        refused = _REFUSED.get(attribute, _not_finite)
        if any(refused(values).any() for values in topic.values(attribute).values()):
            first = next(signal for signal in signals if refused(getattr(signal, attribute)).any())
            return f"{name} at {first.t:.3f} s: {attribute} is not finite"
    return ""


def _not_finite(values: Array) -> NDArray[np.bool_]:
    return ~np.isfinite(values)
