"""A live controller learns from the flight procedure that its commands begin to be flown."""

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("q2q_msgs", reason="the workspace is not built")

from diagnostic_msgs.msg import DiagnosticStatus
from room_node import RoomNode

from q2q_control.flight_procedure.hand_over import RECORDED_STATUS_TOPICS, STATUS_TOPIC, reporter_name
from q2q_control.flight_procedure.observation import VehicleReport
from q2q_control.flight_procedure.procedure_params import FlightProcedureParams, LandingParams
from q2q_control.flight_procedure.state_machine.piloted_flight import OrderExecutor
from q2q_control.flight_procedure.steps import Step
from q2q_control.ros import pid_node
from q2q_control.ros.procedure_services import ProcedureServices
from q2q_model.node.warm_up import synthetic_signal
from q2q_model.signals.cdr.cdr_reader import decode
from q2q_model.signals.cdr.cdr_writer import encode
from q2q_model.signals.values import SwarmCommand, SwarmSetpoint, SwarmState

NAMES = ("cf1", "cf2")


def pitch(node: RoomNode, tick: int) -> float:
    """Return the pitch that is commanded to cf2, 0.1 m behind its setpoint [rad]."""
    state = synthetic_signal(SwarmState, 0.01 * tick, NAMES)
    setpoint = synthetic_signal(SwarmSetpoint, 0.01 * tick, NAMES)
    moved = replace(setpoint, pos=state.pos + np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0]]))
    node.takers["state"](encode(state, tick * 10_000_000))
    node.takers["reference_safe"](encode(moved, tick * 10_000_000))
    return float(decode(node.published["command"][-1], SwarmCommand).pitch[1])


@pytest.mark.parametrize("procedure", [STATUS_TOPIC, *RECORDED_STATUS_TOPICS])
def test_the_integral_of_the_ground_is_not_flown(procedure: str) -> None:
    node = RoomNode("pid", {"aware": False, "live": True, "k_i_xy": 1.0}, {})
    pid_node.build(node)
    first = pitch(node, 1)
    node.takers[procedure](DiagnosticStatus(message=Step.HOVER.value))
    grown = [pitch(node, tick) for tick in range(2, 200)][-1]
    assert grown > 1.2 * first
    node.takers[procedure](DiagnosticStatus(message=Step.TRANSIT.value))
    assert pitch(node, 200) == first


class _OnTheGround(OrderExecutor):
    """Executor of vehicles that report nothing."""

    def reports(self) -> tuple[VehicleReport, ...]:
        return ()


def test_the_steps_are_heard_whatever_the_node_is_called_that_flies_the_vehicles() -> None:
    """Names are relative: `~` would stand for the node's own name, which controllers do not know."""
    room, controller = RoomNode("hall", {}, {}), RoomNode("pid", {"aware": False}, {})
    pid_node.build(controller)
    params = FlightProcedureParams(), LandingParams()
    services = ProcedureServices(room, (), _OnTheGround(), params)
    services.emergency()
    reported = {topic: said for topic, said in room.published.items() if topic in controller.takers}
    assert [one.message for said in reported.values() for one in said] == [Step.STOPPED.value]


def test_the_integral_of_the_ground_is_not_flown_after_a_node_that_was_killed_in_flight() -> None:
    node = RoomNode("pid", {"aware": False, "live": True, "k_i_xy": 1.0}, {})
    pid_node.build(node)
    node.writers[STATUS_TOPIC] = ("radio",)
    node.takers[STATUS_TOPIC](_status("radio", Step.FLIGHT))
    node.writers[STATUS_TOPIC] = ("crazyswarm",)
    node.takers[STATUS_TOPIC](_status("crazyswarm", Step.HOVER))
    first = pitch(node, 1)
    grown = [pitch(node, tick) for tick in range(2, 200)][-1]
    assert grown > 1.2 * first
    node.takers[STATUS_TOPIC](_status("crazyswarm", Step.TRANSIT))
    assert pitch(node, 200) == first


def _status(node: str, step: Step) -> DiagnosticStatus:
    return DiagnosticStatus(name=reporter_name(f"/{node}"), message=step.value)


def test_vehicles_of_another_node_on_the_ground_reset_no_controller_in_flight() -> None:
    node = RoomNode("pid", {"aware": False, "live": True, "k_i_xy": 1.0}, {})
    pid_node.build(node)
    first = pitch(node, 1)
    for tick, (name, step) in enumerate((("a", Step.FLIGHT), ("b", Step.CHECKED), ("a", Step.HOLD)), start=2):
        node.takers[STATUS_TOPIC](DiagnosticStatus(name=name, message=step.value))
        held = [pitch(node, 100 * tick + k) for k in range(100)]
    assert held[0] > 1.2 * first


def test_the_hand_over_of_another_nodes_vehicles_resets_no_controller_in_flight() -> None:
    node = RoomNode("pid", {"aware": False, "live": True, "k_i_xy": 1.0}, {})
    pid_node.build(node)
    first = pitch(node, 1)
    for name, step in (("a", Step.FLIGHT), ("b", Step.HOVER)):
        node.takers[STATUS_TOPIC](DiagnosticStatus(name=name, message=step.value))
    grown = [pitch(node, tick) for tick in range(2, 200)][-1]
    node.takers[STATUS_TOPIC](DiagnosticStatus(name="b", message=Step.TRANSIT.value))
    assert pitch(node, 200) >= grown > 1.2 * first
