"""A controller reports, once per second, who is far from its setpoint: of a plan that begins elsewhere."""

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("q2q_msgs", reason="the workspace is not built")

from diagnostic_msgs.msg import DiagnosticStatus
from room_node import RoomNode

from q2q_control.flight_procedure.hand_over import STATUS_TOPIC, reporter_name
from q2q_control.flight_procedure.steps import Step
from q2q_control.ros import pid_node
from q2q_model.node.warm_up import synthetic_signal
from q2q_model.signals.cdr.cdr_writer import encode
from q2q_model.signals.values import SwarmSetpoint, SwarmState, TrackStatus

NAMES = ("cf1", "cf2")
MESSAGE = "far from their setpoints: cf2 3.0 m: check that the plan begins where they fly"


class PidRoom(RoomNode):
    """Room with a PID without downwash."""

    def __init__(self) -> None:
        super().__init__("pid", {"aware": False}, {})
        self.health = pid_node.build(self).health

    def fly(self, tick: int, aside: float, lost_s: float = 0.0) -> None:
        """Give a tick in which cf2's setpoint is so far beside it [m], and cf2 lost for so long [s]."""
        state = synthetic_signal(SwarmState, 0.01 * tick, NAMES)
        assert isinstance(state, SwarmState)
        state.status[1], state.age[1] = TrackStatus.LOST if lost_s else TrackStatus.TRACKED, lost_s
        setpoint = synthetic_signal(SwarmSetpoint, 0.01 * tick, NAMES)
        moved = replace(setpoint, pos=state.pos + np.array([[0.0, 0.0, 0.0], [aside, 0.0, 0.0]]))
        self.takers["state"](encode(state, tick * 10_000_000))
        self.takers["reference_safe"](encode(moved, tick * 10_000_000))

    def doubt(self, tick: int, aside: float) -> str:
        """Return the doubt of setpoints that is reported after such a tick."""
        self.fly(tick, aside)
        self.report()
        return self.health.doubts["setpoints"]


def test_a_setpoint_that_is_far_is_a_doubt_while_it_is_and_one_line_of_the_log() -> None:
    room = PidRoom()
    doubts = [room.doubt(tick, aside) for tick, aside in enumerate((0.0, 3.0, 3.0, 0.5))]
    assert doubts == ["", MESSAGE, MESSAGE, ""]
    assert room.lines.count(MESSAGE) == 1


def test_a_vehicle_that_the_failsafe_has_landed_is_far_for_that_and_not_for_its_plan() -> None:
    room = PidRoom()
    for tick in range(150):
        room.fly(tick, 0.0, lost_s=0.01 * tick)
    room.report()
    assert "cf2: failsafe LAND" in room.lines
    assert room.doubt(150, 3.0) == "far from their setpoints, brought down by the failsafe: cf2 3.0 m"


def test_a_vehicle_that_lands_or_has_landed_is_not_far_and_is_again_in_the_next_flight() -> None:
    room = PidRoom()
    doubts = []
    steps = Step.FLIGHT, Step.LANDING, Step.DISARMING, Step.CONNECTED, Step.CHECKED, Step.FLIGHT
    for tick, step in enumerate(steps):
        room.takers["procedure/status"](DiagnosticStatus(message=step.value))
        doubts.append(room.doubt(tick, 3.0))
    assert doubts == [MESSAGE, "", "", "", "", MESSAGE]
    assert room.lines.count(MESSAGE) == 2


def test_no_vehicle_is_far_once_the_node_has_gone_that_flew_it() -> None:
    room = PidRoom()
    doubts = []
    for tick, writers in enumerate((("radio",), ())):
        room.writers[STATUS_TOPIC] = writers
        for name in writers:
            status = DiagnosticStatus(name=reporter_name(f"/{name}"), message=Step.FLIGHT.value)
            room.takers[STATUS_TOPIC](status)
        doubts.append(room.doubt(tick, 3.0))
    assert doubts == [MESSAGE, ""]


def test_a_vehicle_in_flight_is_far_whatever_another_node_reports_from_the_ground() -> None:
    room = PidRoom()
    doubts = []
    for tick, (name, step) in enumerate((("a", Step.FLIGHT), ("b", Step.CHECKED), ("a", Step.LANDING))):
        room.takers["procedure/status"](DiagnosticStatus(name=name, message=step.value))
        doubts.append(room.doubt(tick, 3.0))
    assert doubts == [MESSAGE, MESSAGE, ""]
    assert room.lines.count(MESSAGE) == 1
