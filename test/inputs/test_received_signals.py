"""Nodes get signals with arrays like those of flights without ROS, for which set-up compiles the kernels."""

import pytest

pytest.importorskip("q2q_msgs", reason="the workspace is not built")

from q2q_model.diagnostics.health import Health
from q2q_model.node.warm_up import synthetic_signal
from q2q_model.ros.topics.subscriptions import listener
from q2q_model.signals.cdr.cdr_writer import encode
from q2q_model.signals.values import SwarmState


def test_a_node_gets_signals_with_writable_arrays():
    taken: list[SwarmState] = []
    receive = listener("state", SwarmState, lambda _, state: taken.append(state), Health().refuse)
    receive(encode(synthetic_signal(SwarmState, 1.0), 10**9))
    (state,) = taken
    assert [one.flags.writeable for one in (state.pos, state.vel, state.quat, state.status)] == [True] * 4
