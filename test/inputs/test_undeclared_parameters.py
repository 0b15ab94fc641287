"""A parameter that a node does not have is refused in flight by its name, with the nearest one."""

from collections.abc import Iterator

import pytest

pytest.importorskip("q2q_msgs", reason="the workspace is not built")

import rclpy
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import SetParameters, SetParametersAtomically
from rclpy.node import Node

from q2q_control.pid.pid_params import PidParams
from q2q_model.ros.node.node_parameters import declare, name_undeclared
from q2q_sim.processes.domain import own_domain

REFUSED = "Invalid access to undeclared parameter(s): k_pz; did you mean k_p_z?"


@pytest.fixture(scope="module")
def node() -> Iterator[Node]:
    """Return a node with the parameters of the PID controller."""
    with own_domain():
        rclpy.init()
        made = Node("block")
        declare(made, PidParams(), in_flight=True)
        name_undeclared(made)
        yield made
        made.destroy_node()
        rclpy.try_shutdown()


def asked(name: str, value: float) -> Parameter:
    """Return a parameter as a client asks for it."""
    kind = ParameterType.PARAMETER_DOUBLE
    return Parameter(name=name, value=ParameterValue(type=kind, double_value=value))


def test_it_is_refused_by_name_and_the_others_are_set(node: Node) -> None:
    request = SetParameters.Request(parameters=[asked("k_pz", 7.0), asked("k_p_z", 7.0)])
    service = node._parameter_service  # what a client reaches
    one, other = service._set_parameters_callback(request, SetParameters.Response()).results
    assert (one.successful, one.reason) == (False, REFUSED)
    assert (other.successful, node.get_parameter("k_p_z").value) == (True, 7.0)


def test_all_together_are_refused_for_one(node: Node) -> None:
    before = node.get_parameter("k_p_z").value
    request = SetParametersAtomically.Request(parameters=[asked("k_p_z", 8.0), asked("k_pz", 7.0)])
    answer = SetParametersAtomically.Response()
    service = node._parameter_service
    result = service._set_parameters_atomically_callback(request, answer).result
    assert (result.successful, result.reason) == (False, REFUSED)
    assert node.get_parameter("k_p_z").value == before
