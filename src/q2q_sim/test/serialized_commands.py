"""Serialised commands, as a recorder takes them."""

from q2q_model.node.warm_up import synthetic_signal
from q2q_model.signals.cdr.cdr_writer import encode
from q2q_model.signals.values import SwarmCommand


def serialized_at(second: int) -> bytes:
    """Return a serialised command with a stamp."""
    return encode(synthetic_signal(SwarmCommand, float(second), ("cf1",)), second * 10**9)
