"""An intruder on another host reaches nothing of a node that keeps to its machine."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from started_nodes import wait_until_spinning
from two_hosts import ADDRESS, DESK, ROOM

from q2q_model.node.loopback import PROFILE, PROFILE_VARIABLES, has_own_profile, restrict, stays_here

KEPT_DOMAIN, OPEN_DOMAIN = 138, 139
TARGETS = ("command", "plan", "model", "/clock", "all/emergency")
TIMEOUT_S = 600.0
VICTIMS = """
from rclpy.node import Node
from q2q_control.ros import mpc_node
from q2q_model.ros import interference_node
from q2q_model.ros.node.run import run_together
from q2q_sim.ros.simulator_node import Simulator
def build():
    blocks = {"interference": interference_node.build, "mpc": mpc_node.build, "simulator": Simulator}
    nodes = {name: Node(name) for name in blocks}
    return {nodes[name]: make(nodes[name]) for name, make in blocks.items()}
run_together("victims", build)
"""
"""The readers of commands, plans and models, and the server of emergencies, in one process."""
INTRUDER = """
import json, sys
from time import monotonic
import rclpy
from q2q_msgs.msg import Plan, SwarmCommand
from rclpy.qos import DurabilityPolicy, QoSProfile
from rosgraph_msgs.msg import Clock
from std_msgs.msg import String
from std_srvs.srv import Empty
TOPICS = {"command": SwarmCommand, "plan": Plan, "model": String, "/clock": Clock}
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
class Attack:
    def __init__(self, domain):
        context = rclpy.Context()
        context.init(domain_id=domain)
        self.node = rclpy.create_node("intruder", context=context)
        publish = self.node.create_publisher
        self.writers = {name: publish(kind, name, LATCHED) for name, kind in TOPICS.items()}
        self.client = self.node.create_client(Empty, "all/emergency")
    def reached(self):
        readers = {name: writer.get_subscription_count() > 0 for name, writer in self.writers.items()}
        return readers | {"all/emergency": self.client.service_is_ready()}
kept, opened = (Attack(int(domain)) for domain in sys.argv[1:3])
end = monotonic() + float(sys.argv[3])
while not all(opened.reached().values()) and monotonic() < end:
    kept.node.get_clock().sleep_for(rclpy.duration.Duration(seconds=0.05), context=kept.node.context)
print(json.dumps([kept.reached(), opened.reached()]))
"""
"""Writer of commands, plans, models and clock, and caller of emergencies, in two domains.

It stops when it reaches everything in the second, and prints what it reaches in each."""


def clean_environment(**more: str) -> dict[str, str]:
    network = {"ROS_LOCALHOST_ONLY", "ROS_DISCOVERY_SERVER", "ROS_STATIC_PEERS", *PROFILE_VARIABLES}
    return {name: value for name, value in os.environ.items() if name not in network} | more


@pytest.mark.usefixtures("hosts")
def test_an_intruder_who_knows_the_address_reaches_open_nodes_but_none_that_keep_to_their_machine() -> None:
    kept = _victims(ROS_AUTOMATIC_DISCOVERY_RANGE="LOCALHOST", ROS_DOMAIN_ID=str(KEPT_DOMAIN))
    opened = _victims(ROS_AUTOMATIC_DISCOVERY_RANGE="SUBNET", ROS_DOMAIN_ID=str(OPEN_DOMAIN))
    try:
        for one in (kept, opened):
            wait_until_spinning(one)
            assert one.poll() is None, one.communicate()[1]
        words = ["ip", "netns", "exec", DESK, sys.executable, "-c", INTRUDER]
        found = subprocess.run(
            [*words, str(KEPT_DOMAIN), str(OPEN_DOMAIN), str(TIMEOUT_S)],
            env=clean_environment(
                ROS_AUTOMATIC_DISCOVERY_RANGE="SUBNET",
                ROS_STATIC_PEERS=ADDRESS,
                FASTDDS_BUILTIN_TRANSPORTS="UDPv4",  # namespaces share memory, hosts do not
            ),
            capture_output=True,
            text=True,
            check=True,
        )
        assert [kept.poll(), opened.poll()] == [None, None]
    finally:
        for one in (kept, opened):
            one.terminate()
        for one in (kept, opened):
            one.communicate(timeout=TIMEOUT_S)
    reached_kept, reached_open = json.loads(found.stdout)
    assert reached_open == dict.fromkeys(TARGETS, True)
    assert reached_kept == dict.fromkeys(TARGETS, False)


def _victims(**environment: str) -> subprocess.Popen[str]:
    words = ["ip", "netns", "exec", ROOM, sys.executable, "-c", VICTIMS]
    parameters = ["--ros-args", "-p", "use_sim_time:=true"]
    return subprocess.Popen(
        [*words, *parameters],
        env=clean_environment(**environment),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )


PRINT_SHARED = """
import json, re
import rclpy
from q2q_model.ros.node.run import start_ros
start_ros([])
rclpy.create_node("alone")
print(json.dumps(re.findall("/dev/shm/.*fastrtps.*", open("/proc/self/maps").read())))
"""
"""Print what a node has mapped of the middleware's shared memory."""
HERE = {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}


def test_a_node_that_keeps_to_its_machine_is_bound_to_loopback() -> None:
    environment = dict(HERE)
    restrict(environment)
    assert environment[PROFILE_VARIABLES[0]] == str(PROFILE)
    assert not has_own_profile(environment)


@pytest.mark.parametrize("domain", ["", "0", "231"])
def test_a_node_that_keeps_to_its_machine_may_be_in_any_domain_but_the_last(domain: str) -> None:
    """In 232 ports of the 120 participants exceed 65535, at which Fast DDS ends the process."""
    environment = HERE | {"ROS_DOMAIN_ID": domain}
    restrict(environment)
    with pytest.raises(ValueError, match="ROS_DOMAIN_ID is 232, which has too few ports: choose one in \\[0"):
        restrict(environment | {"ROS_DOMAIN_ID": "232"})


def test_a_range_in_which_no_node_finds_another_is_refused() -> None:
    """ROS_LOCALHOST_ONLY overrides it: rcl takes LOCALHOST then."""
    alone = {"ROS_AUTOMATIC_DISCOVERY_RANGE": "OFF"}
    with pytest.raises(
        ValueError, match=r"^ROS_AUTOMATIC_DISCOVERY_RANGE is OFF, .*: unset it, or set LOCALH"
    ):
        restrict(dict(alone))
    environment = alone | {"ROS_LOCALHOST_ONLY": "1"}
    restrict(environment)
    assert environment[PROFILE_VARIABLES[0]] == str(PROFILE)


def test_nodes_in_the_domain_before_the_last_start() -> None:
    opened = subprocess.run(
        [sys.executable, "-c", PRINT_SHARED],
        env=clean_environment(**HERE, ROS_DOMAIN_ID="231"),
        capture_output=True,
        text=True,
        check=True,
    )
    assert json.loads(opened.stdout) == []


def test_a_node_that_keeps_to_its_machine_shares_no_memory() -> None:
    opened = subprocess.run(
        [sys.executable, "-c", PRINT_SHARED],
        env=clean_environment(**HERE, ROS_DOMAIN_ID=str(KEPT_DOMAIN)),
        capture_output=True,
        text=True,
        check=True,
    )
    assert json.loads(opened.stdout) == []


@pytest.mark.parametrize(
    "more",
    [
        {"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"},
        {"ROS_STATIC_PEERS": "10.0.0.2"},
        {"ROS_DISCOVERY_SERVER": "a:1"},
    ],
)
def test_a_node_that_is_informed_of_other_machines_is_not_bound_any_more(more: dict[str, str]) -> None:
    environment = dict(HERE)
    restrict(environment)
    environment |= more
    assert not stays_here(environment)
    restrict(environment)
    assert environment == HERE | more


def test_a_profile_of_the_user_is_kept(tmp_path: Path) -> None:
    file = tmp_path / "mine.xml"
    file.write_text("<dds/>")
    given = HERE | {PROFILE_VARIABLES[1]: str(file)}
    environment = dict(given)
    restrict(environment)
    assert environment == given


@pytest.mark.parametrize("name", PROFILE_VARIABLES)
@pytest.mark.parametrize(
    ("text", "why"), [(None, "No such file or directory"), ("profiles: {}", "no XML: syntax error: line 1, ")]
)
def test_a_profile_that_cannot_be_read_is_refused(
    name: str, text: str | None, why: str, tmp_path: Path
) -> None:
    """The middleware leaves it out with no word of it: nodes would be open to other machines."""
    file = tmp_path / "mine.xml"
    if text is not None:
        file.write_text(text)
    with pytest.raises(ValueError, match=re.escape(f"{name} is {file}, which cannot be read ({why}")):
        restrict(HERE | {name: str(file)})
