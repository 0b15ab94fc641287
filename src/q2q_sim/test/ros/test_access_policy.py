"""Each node may do what its wiring does, and nothing else; only controllers may write commands."""

from collections.abc import Callable
from xml.etree import ElementTree as ET

import pytest
import rclpy
from rclpy.node import Node
from rclpy.parameter import Parameter

from q2q_control.ros import pid_node
from q2q_sim.commands import secure
from q2q_sim.ros.access_policy import AccessProfile, enclaves, policy_text
from q2q_sim.ros.node_survey import NodeInterface, survey
from q2q_sim.tools import secure_nodes

Enclaves = dict[str, tuple[AccessProfile, ...]]
DOMAIN = 137


@pytest.fixture(scope="module")
def nodes() -> list[NodeInterface]:
    return survey()


@pytest.fixture(scope="module")
def granted(nodes: list[NodeInterface]) -> Enclaves:
    return enclaves(nodes, ["cf1"], ["desk"])


def _having(granted: Enclaves, has: Callable[[AccessProfile], bool]) -> set[str]:
    return {path.removeprefix("/q2q/") for path, profiles in granted.items() if any(map(has, profiles))}


def test_only_controllers_may_write_commands(granted: Enclaves) -> None:
    assert _having(granted, lambda one: "command" in one.publish) == {"pid", "mpc", "own_controller", "stack"}


def test_only_the_bridge_and_named_operators_may_call_an_emergency(granted: Enclaves) -> None:
    assert _having(granted, lambda one: "all/emergency" in one.request) == {"crazyswarm", "desk"}


def test_plans_clocks_and_models_have_one_source_or_none(granted: Enclaves) -> None:
    assert _having(granted, lambda one: "plan" in one.publish) == {"trajectory", "stack"}
    assert _having(granted, lambda one: "/clock" in one.publish) == {"simulator"}
    assert _having(granted, lambda one: "model" in one.publish) == set()


def test_an_operator_may_call_the_procedure_and_write_nothing(granted: Enclaves) -> None:
    (desk,) = granted["/q2q/desk"]
    assert {"radio/take_off", "radio/emergency", "crazyswarm/land", "all/emergency"} <= desk.request
    assert "trajectory/start" not in desk.request
    assert desk.publish == {"/rosout", "/parameter_events"}


@pytest.mark.parametrize("name", ["pid", "stack", "bag_play"])
def test_an_operator_may_not_have_the_name_of_a_node(nodes: list[NodeInterface], name: str) -> None:
    with pytest.raises(ValueError, match=f"^operators {name}: .* choose other names$"):
        enclaves(nodes, ["cf1"], ["desk", name])


def test_every_node_but_the_player_of_bags_has_an_enclave(
    nodes: list[NodeInterface], granted: Enclaves
) -> None:
    executables = {node.executable for node in nodes} - {"bag_play"}
    assert set(granted) == {f"/q2q/{name}" for name in executables | {"stack", "desk"}}


def test_the_permissions_of_a_node_are_its_endpoints_in_the_graph(granted: Enclaves) -> None:
    context = rclpy.Context()
    context.init(args=[], domain_id=DOMAIN)
    wanted = {"use_sim_time": True, "vehicles": ["cf1"], "live": True, "correct": True}
    node = Node(
        "pid", context=context, parameter_overrides=[Parameter(k, value=v) for k, v in wanted.items()]
    )
    try:
        kept = pid_node.build(node)
        found = (
            node.get_publisher_names_and_types_by_node("pid", "/"),
            node.get_subscriber_names_and_types_by_node("pid", "/"),
            node.get_service_names_and_types_by_node("pid", "/"),
        )
        del kept
    finally:
        node.destroy_node()
        context.try_shutdown()
    (pid,) = granted["/q2q/pid"]
    later = {"/pid/ready", "/pid/drained"}  # offered by `run`, once the node is built
    for names, endpoints in zip((pid.publish, pid.subscribe, pid.reply), found, strict=True):
        assert {_absolute(name) for name in names} - later == {name for name, _ in endpoints}


def _absolute(name: str) -> str:
    return name if name.startswith("/") else f"/{name.replace('~', 'pid')}"


def test_the_policy_file_says_what_was_granted(granted: Enclaves) -> None:
    read = ET.fromstring(policy_text(granted))  # noqa: S314  (our own text)
    assert read.get("version") == "0.2.0"
    assert [one.get("path") for one in read.iter("enclave")] == list(granted)
    written = [
        (profile.get("node"), right, {name.text for name in listed})
        for profile in read.iter("profile")
        for listed in profile
        for right, allowed in listed.attrib.items()
        if allowed == "ALLOW"
    ]
    profiles = [profile for inside in granted.values() for profile in inside]
    rights = ("publish", "subscribe", "reply", "request")
    assert written == [
        (one.node, right, set(getattr(one, right)))
        for one in profiles
        for right in rights
        if getattr(one, right)
    ]


def test_a_middleware_without_security_is_said_in_a_sentence(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], nodes: list[NodeInterface]
) -> None:
    if secure_nodes.has_security():
        pytest.skip("the middleware here has DDS security")
    monkeypatch.setattr(secure_nodes, "survey", lambda: nodes)
    assert secure.main(["--keystore", "unused"]) == 1
    output = capsys.readouterr()
    assert output.out == ""
    assert output.err.startswith("secure: the ROS middleware of this machine was built without DDS security")
    assert output.err.count("\n") == 1
