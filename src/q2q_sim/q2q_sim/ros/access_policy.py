"""Access policy of DDS security: what each node may publish, read, serve and call, and nothing else.

Every executable has an enclave `/q2q/<executable>` with the topics and services of its survey; `stack` has
those of the nodes within it. An operator's enclave may call `all/emergency` and the flight procedure.
`bag_play` has none: it writes whatever a bag holds. The text is SROS2's policy format 0.2.0; what it does not
allow is denied.

Source: ROS 2 design, "ROS 2 Access Control Policies" (Caiazza, White, Arguedas), design.ros2.org.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from xml.etree import ElementTree as ET

from q2q_control.flight_procedure.steps import Call
from q2q_control.ros.guarded_commands import EMERGENCY
from q2q_sim.ros.node_survey import NodeInterface
from q2q_sim.ros.stack import CONTROL_LOOP
from q2q_sim.ros.surveyed_ports import ANY_VEHICLE

ROOT = "/q2q"
"""Path of the enclaves."""
LEFT_OUT = frozenset({"bag_play"})
OPERATOR_NODE = "procedure_call"
"""Node of `ros2 run q2q_control call`."""


@dataclass(frozen=True, slots=True)
class AccessProfile:
    """Rights of one node; names as in the code, relative to its namespace."""

    node: str
    publish: frozenset[str] = frozenset()
    subscribe: frozenset[str] = frozenset()
    reply: frozenset[str] = frozenset()
    request: frozenset[str] = frozenset()


EVERY_NODE = AccessProfile(
    node="",
    publish=frozenset({"/rosout", "/parameter_events"}),
    subscribe=frozenset({"/clock"}),
    reply=frozenset(
        f"~/{name}"
        for name in (
            "describe_parameters",
            "get_parameter_types",
            "get_parameters",
            "list_parameters",
            "set_parameters",
            "set_parameters_atomically",
            "get_type_description",
        )
    ),
)
"""Rights that rclpy needs for any node; `/clock` with use_sim_time."""


def enclaves(
    nodes: Sequence[NodeInterface], vehicles: Sequence[str], operators: Sequence[str]
) -> dict[str, tuple[AccessProfile, ...]]:
    """Return the profiles of each enclave by its path.

    Args:
        nodes: survey of the nodes.
        vehicles: names of the vehicles; empty allows any name.
        operators: names of the enclaves that may call emergencies and the flight procedure.

    Raises:
        ValueError: an operator has the name of a node.
    """
    taken = sorted({"stack", *(node.executable for node in nodes)} & set(operators))
    if taken:
        raise ValueError(f"operators {', '.join(taken)}: these are enclaves of nodes; choose other names")
    secured = [node for node in nodes if node.executable not in LEFT_OUT]
    profiles = {node.executable: profile_of(node, vehicles or ("*",)) for node in secured}
    within = (_of_any_node("stack"), *(profiles[name] for name in CONTROL_LOOP))
    caller = _operator(profiles.values())
    return (
        {f"{ROOT}/{name}": (profile,) for name, profile in profiles.items()}
        | {f"{ROOT}/stack": within}
        | {f"{ROOT}/{name}": (caller,) for name in operators}
    )


def profile_of(node: NodeInterface, vehicles: Sequence[str]) -> AccessProfile:
    """Return the rights of a node: its ports, and what every node needs."""
    base = _of_any_node(node.executable)

    def named(direction: str) -> frozenset[str]:
        names = [port.name for port, _ in node.ports if port.direction == direction]
        return frozenset(name.replace(ANY_VEHICLE, vehicle) for name in names for vehicle in vehicles)

    return AccessProfile(
        node=node.executable,
        publish=base.publish | named("publishes"),
        subscribe=base.subscribe | named("reads"),
        reply=base.reply | named("serves"),
        request=named("calls"),
    )


def policy_text(granted: Mapping[str, Iterable[AccessProfile]]) -> str:
    """Return the policy file of SROS2."""
    policy = ET.Element("policy", version="0.2.0")
    listed = ET.SubElement(policy, "enclaves")
    for path, profiles in granted.items():
        inside = ET.SubElement(ET.SubElement(listed, "enclave", path=path), "profiles")
        for profile in profiles:
            _add_profile(inside, profile)
    ET.indent(policy)
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{ET.tostring(policy, "unicode")}\n'


def _add_profile(inside: ET.Element, profile: AccessProfile) -> None:
    made = ET.SubElement(inside, "profile", ns="/", node=profile.node)
    lists = (
        ("topics", "publish", profile.publish),
        ("topics", "subscribe", profile.subscribe),
        ("services", "reply", profile.reply),
        ("services", "request", profile.request),
    )
    for kind, right, names in lists:
        if names:
            allowed = ET.SubElement(made, kind, {right: "ALLOW"})
            for name in sorted(names):
                ET.SubElement(allowed, kind.removesuffix("s")).text = name


def _of_any_node(name: str) -> AccessProfile:
    return replace(EVERY_NODE, node=name)


def _operator(profiles: Iterable[AccessProfile]) -> AccessProfile:
    """Return the rights of an operator: emergencies, and the calls of nodes that fly the procedure."""
    calls = {f"~/{call.value}" for call in Call}
    served = {
        f"{one.node}/{name.removeprefix('~/')}"
        for one in profiles
        if f"~/{Call.EMERGENCY.value}" in one.reply
        for name in calls & one.reply
    }
    return replace(_of_any_node(OPERATOR_NODE), request=frozenset({EMERGENCY, *served}))
