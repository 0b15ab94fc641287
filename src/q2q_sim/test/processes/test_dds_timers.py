"""A flight's publications leave Fast DDS's timer thread asleep."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from q2q_model.node.loopback import PROFILE_VARIABLES
from q2q_sim.processes import dds_profile
from q2q_sim.processes.dds_profile import HEARTBEAT_NS, SUPPRESSION_NS, profile_environment
from q2q_sim.processes.domain import own_domain

CALLS = 100
ANSWER = """
import rclpy
from std_msgs.msg import Empty
rclpy.init()
node = rclpy.create_node("answerer")
writer = node.create_publisher(Empty, "answer", 1)
node.create_subscription(Empty, "call", writer.publish, 1)
rclpy.spin(node)
"""
CALL = f"""
from pathlib import Path
import rclpy
from std_msgs.msg import Empty

def call():
    heard.clear()
    while not heard:
        writer.publish(Empty())
        rclpy.spin_once(node, timeout_sec=1.0)

def wakes():
    (timers,) = [one for one in Path("/proc/self/task").iterdir() if "dds.ev" in (one / "comm").read_text()]
    return int((timers / "status").read_text().partition("voluntary_ctxt_switches:")[2].split()[0])

rclpy.init()
node = rclpy.create_node("caller")
heard = []
writer = node.create_publisher(Empty, "call", 1)
node.create_subscription(Empty, "answer", heard.append, 1)
call()  # they know each other
before = wakes()
for _ in range({CALLS}):
    call()
print(wakes() - before)
rclpy.shutdown()
"""


def test_a_publication_wakes_no_timer(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in PROFILE_VARIABLES:
        monkeypatch.delenv(name, raising=False)
    with (
        own_domain(),
        subprocess.Popen([sys.executable, "-c", ANSWER], env=_environment(tmp_path)) as answerer,
    ):
        try:
            seldom = _least_wakes(tmp_path)
            with_none = dds_profile.WRITERS.replace(f"{SUPPRESSION_NS}", "0")
            monkeypatch.setattr(dds_profile, "WRITERS", with_none)
            often = _least_wakes(tmp_path)
        finally:
            answerer.kill()
    assert often > 2 * seldom  # 10 times as often on an idle machine


def test_suppression_ends_before_the_next_heartbeat() -> None:
    assert 0 < SUPPRESSION_NS < HEARTBEAT_NS


def _least_wakes(folder: Path) -> int:
    """Return the fewest wakes of three nodes: a busy machine adds some, and joins a few."""
    return min(_wakes(folder) for _ in range(3))


def _wakes(folder: Path) -> int:
    """Return how often the timer thread of a node wakes while another answers its calls."""
    done = subprocess.run(
        [sys.executable, "-c", CALL], env=_environment(folder), capture_output=True, text=True, check=True
    )
    return int(done.stdout)


def _environment(folder: Path) -> dict[str, str]:
    return {**os.environ, **profile_environment(folder, os.sched_getaffinity(0))}
