"""Whatever ends a flight, its nodes end with it."""

import os
import re
import select
import signal
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

from q2q_model.bag import BagReader, read_flight
from q2q_sim.processes.fork_server import say_in_a_line

NODES = 7
ORPHAN = """
import os
from q2q_sim.processes.fork_server import join_session

alive, held = os.pipe()
if os.fork() == 0:  # the fork server's part: it dies before its fork settles
    os.fork() and os._exit(0)
    os.close(held)
    os.read(alive, 1)
    join_session(frozenset())
    print("runs on")
else:
    os.close(held)
    os.wait()
"""
"""Fork that settles only after its parent has died."""
POOL = """
import os
from q2q_sim.processes.worker_pool import worker_pool

if __name__ == "__main__":
    pool = worker_pool(2)
    print(pool.submit(os.getpid).result(), flush=True)
    os.read(os.pipe()[0], 1)
"""
"""Command that waits for ever next to its pool."""
INTERRUPTED_POOL = """
import os, signal, sys
from concurrent.futures.process import BrokenProcessPool
from q2q_sim.processes.worker_pool import worker_pool

sys.path.insert(0, {folder!r})
if __name__ == "__mp_main__" and {starting}:
    os.kill(os.getpid(), signal.SIGINT)
if __name__ == "__main__":
    import work
    with worker_pool(1) as pool:
        try:
            pool.submit(work.act).result()
        except (BrokenProcessPool, KeyboardInterrupt) as ended:
            print(type(ended).__name__)
"""
"""Command whose worker is interrupted while it starts, imports its work, or works."""
WORK = """
import os, signal

def act(): os.kill(os.getpid(), signal.SIGINT) if {acting} else print("acts")

if os.environ.get("PARENT") != str(os.getppid()) and {importing}: os.kill(os.getpid(), signal.SIGINT)
"""
LONG_S = 3000.0
LONG = f"vehicles: {{a: [{{t: 0, pos: [0, 0, 1]}}, {{t: {LONG_S}, pos: [1, 0, 1]}}]}}"
"""Scenario that takes minutes even in lockstep."""
TIMEOUT_S = 90.0


def start_flight(*words: str) -> subprocess.Popen[str]:
    """Start a flight with the words that follow `fly`."""
    environment = {key: value for key, value in os.environ.items() if key != "ROS_DOMAIN_ID"}
    return subprocess.Popen(
        [sys.executable, "-m", "q2q_sim.commands.fly", *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=environment,
    )


def children(parent: int) -> list[int]:
    """Return the process ids of a process's children, the oldest first; none of one that is gone."""
    try:
        return [int(word) for word in Path(f"/proc/{parent}/task/{parent}/children").read_text().split()]
    except OSError:
        return []


def nodes_of(flight: subprocess.Popen[str], number: int = NODES) -> list[int]:
    """Return the process ids of a flight's nodes, children of its fork server, once all are started."""
    while flight.poll() is None:
        families = [children(child) for child in children(flight.pid)]
        found = next((family for family in families if len(family) >= number), None)
        if found is not None:
            return found
        try:
            flight.wait(0.02)
        except subprocess.TimeoutExpired:
            continue
    raise AssertionError(flight.communicate()[1])


def wait_for_bytes(flight: subprocess.Popen[str], file: Path, size: int) -> None:
    """Return once a file of a flight has a size [bytes]."""
    while not file.exists() or file.stat().st_size < size:
        assert flight.poll() is None
        with suppress(subprocess.TimeoutExpired):
            flight.wait(0.02)


def ends(node: int) -> bool:
    """Return whether a process ends within TIMEOUT_S; a process that is gone has ended."""
    try:
        handle = os.pidfd_open(node)
    except ProcessLookupError:
        return True
    try:
        return bool(select.select([handle], [], [], TIMEOUT_S)[0])
    finally:
        os.close(handle)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_a_flight_that_is_ended_leaves_no_node_behind(number: signal.Signals) -> None:
    flight = start_flight("table6", "--live")
    nodes = nodes_of(flight)
    flight.send_signal(number)
    _, lines = flight.communicate(timeout=TIMEOUT_S)
    assert all(ends(node) for node in nodes)
    assert "Traceback" not in lines
    assert flight.returncode == (-signal.SIGKILL if number == signal.SIGKILL else 130)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_a_lockstep_flight_that_is_ended_closes_its_bag(number: signal.Signals, tmp_path: Path) -> None:
    """The simulator's timer for the next ticks is always overdue there."""
    (tmp_path / "long.yaml").write_text(LONG)
    flight = start_flight(str(tmp_path / "long.yaml"), "--bag", str(tmp_path / "bag"))
    wait_for_bytes(flight, tmp_path / "bag" / "bag_0.mcap", 300_000)
    (stack,) = nodes_of(flight, 1)
    flight.send_signal(number)
    _, lines = flight.communicate(timeout=TIMEOUT_S)
    assert ends(stack)
    assert flight.returncode == (-signal.SIGKILL if number == signal.SIGKILL else 130)
    assert ("fly: interrupted" in lines) == (number != signal.SIGKILL)
    assert BagReader(tmp_path / "bag").repairs == ()
    assert np.ptp(read_flight(tmp_path / "bag").t) < 0.5 * LONG_S


def test_a_node_that_is_killed_in_flight_is_named_and_the_others_end() -> None:
    flight = start_flight("table6", "--live")
    nodes = nodes_of(flight)
    os.kill(nodes[1], signal.SIGKILL)
    _, lines = flight.communicate(timeout=TIMEOUT_S)
    assert all(ends(node) for node in nodes)
    assert flight.returncode == 1
    assert "mocap_filter ended with status -9" in lines


def test_a_node_whose_parent_died_before_it_settled_does_not_run_on() -> None:
    done = subprocess.run([sys.executable, "-c", ORPHAN], capture_output=True, text=True, check=False)
    assert done.stdout == ""
    assert re.fullmatch(r"process \d+, which started this one, has ended\n", done.stderr)


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL])
def test_a_command_that_is_killed_leaves_no_process_of_its_pool_behind(number: signal.Signals) -> None:
    command = subprocess.Popen([sys.executable, "-c", POOL], stdout=subprocess.PIPE, text=True)
    assert command.stdout is not None
    worker = int(command.stdout.readline())
    command.send_signal(number)
    command.communicate(timeout=TIMEOUT_S)
    assert ends(worker)


@pytest.mark.parametrize(
    ("when", "ended"),
    [("starting", "BrokenProcessPool"), ("importing", "BrokenProcessPool"), ("acting", "Interrupted")],
)
def test_the_processes_of_a_pool_are_interrupted_without_a_word(
    tmp_path: Path, when: str, ended: str
) -> None:
    places = {place: place == when for place in ("starting", "importing", "acting")}
    (tmp_path / "work.py").write_text(WORK.format(**places))
    (tmp_path / "command.py").write_text(INTERRUPTED_POOL.format(folder=str(tmp_path), **places))
    command = [sys.executable, str(tmp_path / "command.py")]
    environment = os.environ | {"PARENT": str(os.getpid())}
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=environment)
    assert (done.stdout, done.stderr) == (f"{ended}\n", "")


@pytest.mark.parametrize(
    ("error", "said"),
    [
        (EOFError("Ran out of input"), "the flight was killed while this node was starting\n"),
        (ValueError("a defect"), "ValueError: a defect\n"),
    ],
)
def test_a_node_that_starts_as_its_flight_is_killed_says_so_in_a_line(
    error: Exception, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    say_in_a_line(type(error), error, None)
    assert capsys.readouterr().err == said
