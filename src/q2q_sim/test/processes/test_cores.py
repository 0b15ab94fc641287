"""The chain of a tick stays on one core, and two flights keep their chains apart."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from q2q_model.node.loopback import PROFILE_VARIABLES
from q2q_sim.processes.cores import beside_chain, cores_of
from q2q_sim.processes.dds_profile import profile_environment

PRINT_TIMERS = """
import os
from pathlib import Path
import rclpy
rclpy.init()
node = rclpy.create_node("timers")
for task in Path("/proc/self/task").iterdir():
    if (task / "comm").read_text().startswith("dds.ev"):
        print(*os.sched_getaffinity(int(task.name)))
rclpy.shutdown()
"""
CHAIN = ("simulator", "mocap_filter", "interference", "pid", "mpc")


def test_the_chain_has_one_core_and_the_rest_have_the_others() -> None:
    assert {cores_of(name, 20, {0, 1, 2, 3}) for name in CHAIN} == {frozenset({0})}
    assert cores_of("bag_record", 20, {0, 1, 2, 3}) == {1, 2, 3}


def test_neighbouring_domains_chain_on_different_cores() -> None:
    assert cores_of("pid", 20, {3, 5}) == {3}
    assert cores_of("pid", 21, {3, 5}) == {5}


def test_on_one_core_all_share_it() -> None:
    assert cores_of("pid", 20, {7}) == cores_of("trajectory", 20, {7}) == {7}


def test_timers_run_beside_the_chain(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in PROFILE_VARIABLES:
        monkeypatch.delenv(name, raising=False)
    output = profile_environment(tmp_path, beside_chain(21, {0, 1, 3}))[PROFILE_VARIABLES[0]]
    assert f"<affinity>{0b1010}</affinity>" in Path(output).read_text()


def test_the_middleware_reads_the_profile(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in PROFILE_VARIABLES:
        monkeypatch.delenv(name, raising=False)
    core = max(os.sched_getaffinity(0))
    output = subprocess.run(
        [sys.executable, "-c", PRINT_TIMERS],
        env={**os.environ, **profile_environment(tmp_path, {core})},
        capture_output=True,
        text=True,
        check=True,
    )
    assert output.stdout.split() == [str(core)]


def test_a_profile_of_the_users_own_is_left_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(PROFILE_VARIABLES[1], "mine.xml")
    assert profile_environment(tmp_path, {1}) == {}
