"""What the node `mpc` does with plans that come in flight: an invalid one must not end the controller."""

from array import array
from dataclasses import replace

import numpy as np
import pytest
from resting_signals import resting_setpoint

pytest.importorskip("q2q_msgs", reason="the workspace is not built")

from q2q_msgs.msg import Plan
from room_node import RoomNode

from q2q_control.ros import mpc_node
from q2q_model.diagnostics.health import Health, Level, health_report
from q2q_model.ros.node.input_warnings import AbsentNames
from q2q_model.ros.topics.plan_message import encode_plan
from q2q_model.signals.cdr.cdr_writer import encode
from q2q_model.signals.values import Names, SwarmSetpoint
from q2q_model.trajectory.polynomials import AXES, SwarmPlan, Trajectory

PLAN = SwarmPlan(("cf1", "cf2"), (Trajectory(np.array([5.0]), np.zeros((1, AXES, 2))),) * 2)


def plan(**changed: object) -> Plan:
    """Return the message of a plan of two vehicles, with some fields changed."""
    message = encode_plan(PLAN, 0)
    for name, value in changed.items():
        setattr(message, name, value)
    return message


def setpoint(names: Names) -> SwarmSetpoint:
    still = np.zeros((len(names), 3))
    return resting_setpoint(0.0, names, still)


def test_an_invalid_plan_is_refused_with_its_reason_and_the_next_one_is_taken() -> None:
    node = RoomNode("mpc", {"model": "none"}, {})
    wiring = mpc_node.build(node)
    for changed, reason in (
        ({"coefficients": array("d", [np.nan] * 16)}, "a coefficient is not finite"),
        ({"coefficients": array("d", [0.0])}, "plan has 1 coefficients; its pieces need 16"),
        ({"names": ["cf1", "cf1"]}, "duplicate vehicle names in cf1, cf1"),
        ({"durations": array("d", [5.0, 1e9])}, "plan of 1e+09 s; must be at most 50000 s for 2 vehicles"),
        ({"names": [], "pieces": [], "durations": [], "coefficients": []}, "at least one piece"),
    ):
        node.takers["plan"](plan(**changed))
        assert reason in wiring.health.last_refusal
        assert wiring.health.last_refusal.startswith("plan (the last one is kept): ")
    assert health_report(Health(), wiring.health).level is Level.ERROR
    node.takers["plan"](plan())
    assert wiring.health.refused == 5


def test_a_plan_far_from_the_references_is_a_doubt_until_another_one_comes_and_one_line_of_the_log() -> None:
    node = RoomNode("mpc", {"model": "none"}, {})
    wiring = mpc_node.build(node)
    away = replace(setpoint(PLAN.names), pos=np.array([[0.0, 0.0, 0.0], [3.0, 0.0, 4.0]]))
    report = "plan: far from the setpoints: cf2 5.0 m: check that they come from this plan"
    node.takers["plan"](plan())
    for tick in range(3):
        node.takers["reference_safe"](encode(away, tick * 10_000_000))
    assert health_report(Health(), wiring.health).summary == report
    assert node.lines.count(f"{report}; flown without looking ahead") == 1
    node.takers["plan"](plan())
    node.takers["reference_safe"](encode(setpoint(PLAN.names), 30_000_000))
    assert health_report(Health(), wiring.health).level is Level.STALE


def test_a_node_that_starts_after_the_plan_has_ended_has_no_doubt_while_vehicles_hold_there() -> None:
    node = RoomNode("mpc", {"model": "none"}, {})
    wiring = mpc_node.build(node)
    node.takers["plan"](plan())
    for second in (60, 61):
        hold = replace(setpoint(PLAN.names), t=float(second))
        node.takers["reference_safe"](encode(hold, second * 10**9))
    assert health_report(Health(), wiring.health).level is Level.STALE
    assert node.lines == []
    away = replace(hold, t=62.0, pos=np.array([[0.0, 0.0, 0.0], [3.0, 0.0, 4.0]]))
    node.takers["reference_safe"](encode(away, 62 * 10**9))
    report = health_report(Health(), wiring.health).summary
    assert report.startswith("plan: ended 55.0 s before it arrived, far from the setpoints: cf2 5.0 m")
    assert node.lines == [f"{report}; flown without looking ahead"]


@pytest.mark.parametrize("plan_first", [True, False])
def test_references_that_the_plan_does_not_have_are_reported_once_and_kept_in_health(
    plan_first: bool,
) -> None:
    node, health = RoomNode("mpc", {}, {}), Health()
    names = AbsentNames(node, "plan", "{}: flown without looking ahead", health)
    if plan_first:
        names.take_source(("x", "cf2"))
    for _ in range(3):
        names.update(0, setpoint(("cf1", "cf2")))
    assert plan_first or node.lines == []  # no plan has come: nothing is missing from it
    names.take_source(("x", "cf2"))
    assert node.lines == ["cf1 not in plan, which has x, cf2: flown without looking ahead"]
    assert health_report(Health(), health).summary == "cf1 not in plan, which has x, cf2"
    names.take_source(("cf2", "cf1"))
    assert health_report(Health(), health).level is Level.STALE
    assert len(node.lines) == 1
