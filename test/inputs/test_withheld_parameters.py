"""A parameter that a node declares only with another is refused with what it needs."""

from collections.abc import Iterator

import pytest

pytest.importorskip("q2q_msgs", reason="the workspace is not built")

import rclpy
from rclpy.node import Node
from rclpy.parameter import Parameter

from q2q_control.ros import pid_node
from q2q_model.ros.node.node_parameters import refuse_undeclared
from q2q_planner.ros import replanner_node
from q2q_sim.processes.domain import own_domain
from q2q_sim.ros.simulator_node import Simulator

BUILDERS = {"pid": pid_node.build, "replanner": replanner_node.build, "simulator": Simulator}


@pytest.fixture(scope="module", autouse=True)
def ros() -> Iterator[None]:
    with own_domain():
        rclpy.init()
        yield
        rclpy.try_shutdown()


def refusal(name: str, given: dict[str, object]) -> str:
    """Return why a node with these parameters is refused; empty if it is not."""
    node = Node(name, parameter_overrides=[Parameter(key, value=value) for key, value in given.items()])
    try:
        BUILDERS[name](node)
        refuse_undeclared([node])
    except ValueError as refused:
        return str(refused)
    finally:
        node.destroy_node()
    return ""


@pytest.mark.parametrize(
    ("node", "given", "expected"),
    [
        ("pid", {"latency": 0.03}, "parameter latency needs correct:=true"),
        ("pid", {"model": "none"}, "parameter model needs correct:=true"),
        ("pid", {"latency": 0.03, "correct": True}, ""),
        ("pid", {"latencies": 0.03, "correct": True}, "no parameter latencies; did you mean latency?"),
        ("replanner", {"safe.eps": 0.3}, "parameter safe.eps needs law:=safe"),
        ("replanner", {"eps": 0.3, "law": "safe"}, "parameter eps needs law:=paper"),
        ("replanner", {"safe.eps": 0.3, "law": "safe"}, ""),
        ("simulator", {"crtp_port": 0}, "parameter crtp_port needs crtp:=true"),
        ("simulator", {"crtp_port": 0, "crtp": True}, ""),
    ],
)
def test_a_withheld_parameter_is_refused_with_what_it_needs(
    node: str, given: dict[str, object], expected: str
) -> None:
    assert refusal(node, given) == expected
