"""Keystore of DDS security for q2q's nodes, made by SROS2 from their access policy."""

import os
import subprocess
import sys
from argparse import Namespace
from pathlib import Path
from shutil import which
from tempfile import TemporaryDirectory

from q2q_model.documents.written_file import write_text
from q2q_sim.ros.access_policy import ROOT, enclaves, policy_text
from q2q_sim.ros.node_survey import survey

LACKING = ("doesn't have the security libraries", "does not have security support")
"""Refusals of rmw_fastrtps and rmw_cyclonedds that were built without security."""
PROBE = "import rclpy; rclpy.init(args=[]); rclpy.create_node('probe')"
NO_SECURITY = (
    "the ROS middleware of this machine was built without DDS security (the wheels of scripts/setup are): "
    "source a ROS 2 Jazzy that has it, or keep to this machine (docs/security.md)"
)
NO_SROS2 = "`ros2 security` is not installed: source a ROS 2 Jazzy with it (sudo apt install ros-jazzy-sros2)"
USE = """secure: {count} enclaves in {keystore}, for ROS_DOMAIN_ID {domain}. For every node:
    export ROS_SECURITY_ENABLE=true ROS_SECURITY_STRATEGY=Enforce ROS_SECURITY_KEYSTORE={keystore}
    ros2 run q2q_control pid --ros-args --enclave {root}/pid"""


def run(args: Namespace) -> int:
    """Write the policy, or policy and keystore; return the exit status."""
    granted = enclaves(survey(), args.vehicles, args.operators)
    text = policy_text(granted)
    if args.policy:
        write_text(text, args.policy)
        print(f"secure: policy of {len(granted)} enclaves in {args.policy}")
        return 0
    lacking = NO_SECURITY if not has_security() else NO_SROS2 if not has_sros2() else ""
    if lacking:
        print(f"secure: {lacking}", file=sys.stderr)
        return 1
    status = make_keystore(args.keystore, text)
    if status == 0:
        domain = os.environ.get("ROS_DOMAIN_ID", "0")
        keystore = args.keystore.resolve()
        print(USE.format(count=len(granted), keystore=keystore, domain=domain, root=ROOT))
    return status


def has_security() -> bool:
    """Return whether the middleware has security plug-ins: one without says so when they are asked for."""
    with TemporaryDirectory(prefix="q2q-secure-") as keystore:
        Path(keystore, "enclaves").mkdir()
        asked = {
            "ROS_SECURITY_ENABLE": "true",
            "ROS_SECURITY_STRATEGY": "Enforce",
            "ROS_SECURITY_KEYSTORE": keystore,
            "ROS_SECURITY_ENCLAVE_OVERRIDE": "/",
        }
        done = subprocess.run(
            [sys.executable, "-c", PROBE],
            env={**os.environ, **asked},
            capture_output=True,
            text=True,
            check=False,
        )
    return not any(words in done.stderr for words in LACKING)


def has_sros2() -> bool:
    """Return whether the command `ros2 security` is installed."""
    if which("ros2") is None:
        return False
    return subprocess.run(["ros2", "security", "--help"], capture_output=True, check=False).returncode == 0


def make_keystore(keystore: Path, policy: str) -> int:
    """Make keys and signed permissions of a policy; return the exit status of SROS2."""
    file = keystore / "policy.xml"
    write_text(policy, file)
    words = ["ros2", "security", "generate_artifacts", "-k", str(keystore), "-p", str(file)]
    return subprocess.run(words, check=False).returncode
