"""What a node logs, and grades its health by, when vehicles are cut, alone or commanded by two nodes."""

import math

import pytest

pytest.importorskip("q2q_msgs", reason="the workspace is not built")

from room_node import RoomNode
from std_srvs.srv import Empty

from q2q_control.ros import pid_node
from q2q_model.node.health import Health, HealthReport, Level, report
from q2q_model.node.rehearsal import rehearsal
from q2q_model.ros.node.tick import TickWiring
from q2q_model.signals.cdr import encode
from q2q_model.signals.stamps import stamp_from_time
from q2q_model.signals.values import SwarmCommand, SwarmSetpoint, SwarmState

CUT = "motors cut by all/emergency: restart this node to fly"


def controller(**given: object) -> tuple[RoomNode, TickWiring[SwarmCommand]]:
    """Return a PID node without downwash, and its wiring."""
    node = RoomNode("pid", {"aware": False, **given}, {})
    return node, pid_node.build(node)


def fly(node: RoomNode, first: float, last: float, lost_since: float = math.inf) -> None:
    """Give the node the ticks of these times [s]; the first vehicle was last seen at `lost_since` [s]."""
    for k in range(round(100 * first), round(100 * last)):
        t = 0.01 * k
        state = rehearsal(SwarmState, t, unseen=t > lost_since)
        if isinstance(state, SwarmState):
            state.age[0] = max(t - lost_since, 0.0)
        node.takers["state"](encode(state, stamp_from_time(t)))
        node.takers["reference_safe"](encode(rehearsal(SwarmSetpoint, t), stamp_from_time(t)))


def emergency(node: RoomNode) -> None:
    """Call all/emergency."""
    node.services["all/emergency"].ask(Empty.Request(), Empty.Response())


def graded(wiring: TickWiring[SwarmCommand]) -> HealthReport:
    """Return the grade of the node's life."""
    return report(Health(), wiring.health)


def test_an_emergency_is_one_error_line_at_once_and_an_error_of_health() -> None:
    node, wiring = controller()
    fly(node, 0.0, 2.0)
    assert (node.lines, graded(wiring).level) == ([], Level.OK)
    emergency(node)
    assert node.lines == [CUT]
    fly(node, 2.0, 2.2)
    assert node.lines == [CUT]
    assert (graded(wiring).level, graded(wiring).summary) == (Level.ERROR, CUT)
    fly(node, 0.0, 0.2)  # a simulator started again
    assert node.lines == [CUT, f"cf1, cf2: {CUT}"]


def test_an_emergency_before_the_first_tick_is_told_as_well() -> None:
    node, wiring = controller()
    emergency(node)
    assert (node.lines, graded(wiring).summary) == ([CUT], CUT)


def test_a_lost_vehicle_is_told_phase_by_phase_and_its_cut_is_an_error() -> None:
    node, wiring = controller()
    fly(node, 0.0, 0.5)
    fly(node, 0.5, 2.0, lost_since=0.5)
    assert graded(wiring).summary == "in fallback: cf1: failsafe LAND"
    fly(node, 2.0, 6.5, lost_since=0.5)
    assert node.lines == [
        "cf1: failsafe HOLD",
        "cf1: failsafe LEVEL",
        "cf1: failsafe LAND",
        "cf1: motors cut, not measured for cut_s: restart this node to fly",
    ]
    assert (graded(wiring).level, graded(wiring).summary) == (Level.ERROR, node.lines[-1])
