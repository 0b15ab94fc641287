"""A live controller hears from the flight procedure that its commands begin to be flown."""

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("q2q_msgs", reason="the workspace is not built")

from diagnostic_msgs.msg import DiagnosticStatus
from room_node import RoomNode

from q2q_control.flight_procedure.steps import Step
from q2q_control.ros import pid_node
from q2q_control.ros.guarded_commands import PROCEDURES
from q2q_model.node.rehearsal import rehearsal
from q2q_model.signals.cdr import decode, encode
from q2q_model.signals.values import SwarmCommand, SwarmSetpoint, SwarmState

NAMES = ("cf1", "cf2")


def pitch(node: RoomNode, tick: int) -> float:
    """Return the pitch that is commanded to cf2, 0.1 m behind its setpoint [rad]."""
    state = rehearsal(SwarmState, 0.01 * tick, NAMES)
    setpoint = rehearsal(SwarmSetpoint, 0.01 * tick, NAMES)
    moved = replace(setpoint, pos=state.pos + np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0]]))
    node.takers["state"](encode(state, tick * 10_000_000))
    node.takers["reference_safe"](encode(moved, tick * 10_000_000))
    return float(decode(node.published["command"][-1], SwarmCommand).pitch[1])


@pytest.mark.parametrize("procedure", PROCEDURES)
def test_the_integral_of_the_ground_is_not_flown(procedure: str) -> None:
    node = RoomNode("pid", {"aware": False, "live": True, "k_i_xy": 1.0}, {})
    pid_node.build(node)
    first = pitch(node, 1)
    node.takers[procedure](DiagnosticStatus(message=Step.HOVER.value))
    grown = [pitch(node, tick) for tick in range(2, 200)][-1]
    assert grown > 1.2 * first
    node.takers[procedure](DiagnosticStatus(message=Step.GLIDE.value))
    assert pitch(node, 200) == first
