"""Repeated stamps: a block that has processed a tick returns the same output again and keeps its memory."""

from typing import TypeGuard, TypeVar

from q2q_model.signals.layout import Signal
from q2q_model.signals.values import Names

S = TypeVar("S", bound=Signal)


def is_repeated(last: S | None, t: float, names: Names) -> TypeGuard[S]:
    """Return whether a block's last output is that of the tick at t [s] for the vehicles `names`."""
    return last is not None and last.t == t and last.names == names
