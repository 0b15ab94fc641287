"""Time from a command to its first word: help, refusals, `fly`, and each node until it is ready.

The references are `python -c pass` and `python -c "import rclpy, numba"`: what Python itself takes, and the
least that a node with compiled loops takes. Every figure is the best of REPEATS.
"""

import os
import signal
import subprocess
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter, sleep

import rclpy
from rclpy.node import Node
from std_srvs.srv import Trigger

from q2q_model.trajectory import plan_file
from q2q_sim.loop import flight_blocks
from q2q_sim.processes.domain import own_domain
from q2q_sim.scenarios import library
from row import Row

ROOT = Path(__file__).resolve().parents[1]
REPEATS = 3
LOOK_S = 0.01
"""How often a node is asked whether it is ready [s]."""
TIMEOUT_S = 60.0
SCENARIO = "table6"
REFERENCE = "python -c pass"
HEAVY = 'python -c "import rclpy, numba"'
WORDS: dict[str, Sequence[str]] = {
    "scripts/fly --help": ("scripts/fly", "--help"),
    "scripts/fly tabel6": ("scripts/fly", "tabel6"),
    "scripts/bench --help": ("scripts/bench", "--help"),
    "ros2 run q2q_sim report --help": ("ros2", "run", "q2q_sim", "report", "--help"),
    "ros2 run q2q_sim report none": ("ros2", "run", "q2q_sim", "report", "none"),
    "ros2 run q2q_model identify --help": ("ros2", "run", "q2q_model", "identify", "--help"),
    "ros2 run q2q_planner plan none": ("ros2", "run", "q2q_planner", "plan", "none", "--out", "none"),
}
NODES = (
    ("q2q_model", "mocap_filter"),
    ("q2q_model", "interference"),
    ("q2q_planner", "trajectory"),
    ("q2q_planner", "replanner"),
    ("q2q_control", "pid"),
    ("q2q_control", "mpc"),
    ("q2q_sim", "simulator"),
    ("q2q_sim", "bag_record"),
)


def run() -> list[Row]:
    """Return a row per command, each with its reference in this run."""
    plain = _best(lambda: _ended(sys.executable, "-c", "pass"))
    heavy = _best(lambda: _ended(sys.executable, "-c", "import rclpy, numba"))
    first = _best(lambda: _first_line("scripts/fly", SCENARIO))
    rows = [Row(REFERENCE, plain, "s"), Row(HEAVY, heavy, "s")]
    for name, words in WORDS.items():
        seconds = _best(lambda words=words: _ended(*words))  # type: ignore[misc]
        rows.append(Row(name, seconds, "s", REFERENCE, plain / seconds))
    rows.append(Row(f"first line of scripts/fly {SCENARIO}", first, "s", REFERENCE, plain / first))
    with TemporaryDirectory() as scratch, own_domain():
        rclpy.init()
        try:
            rows += [_node_row(package, name, Path(scratch), heavy) for package, name in NODES]
        finally:
            rclpy.try_shutdown()
    return rows


def _node_row(package: str, name: str, folder: Path, heavy: float) -> Row:
    seconds = _best(lambda: _ready(package, name, folder))
    return Row(f"ros2 run {package} {name}, until ready", seconds, "s", HEAVY, heavy / seconds)


def _best(measure: Callable[[], float]) -> float:
    return min(measure() for _ in range(REPEATS))


def _ended(*words: str) -> float:
    """Return how long a command takes [s]."""
    began = perf_counter()
    subprocess.run(words, cwd=ROOT, capture_output=True, check=False)
    return perf_counter() - began


def _first_line(*words: str) -> float:
    """Return how long a command takes to its first line [s]; it is interrupted then."""
    began = perf_counter()
    with subprocess.Popen(
        words, cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, start_new_session=True
    ) as process:
        if process.stderr is not None:
            process.stderr.readline()
        seconds = perf_counter() - began
        os.killpg(process.pid, signal.SIGINT)
        process.communicate()
    return seconds


def _ready(package: str, name: str, folder: Path) -> float:
    """Return how long a node takes from `ros2 run` until it answers `~/ready` [s]."""
    parameters = _parameters(name, folder)
    words = ["ros2", "run", package, name, "--ros-args", *(w for one in parameters for w in ("-p", one))]
    watcher = Node("start_watcher")
    client = watcher.create_client(Trigger, f"{name}/ready")
    began = perf_counter()
    process = subprocess.Popen(words, cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        while not client.service_is_ready():  # wait_for_service looks every 0.25 s only
            sleep(LOOK_S)
            if process.poll() is not None or perf_counter() - began > TIMEOUT_S:
                raise RuntimeError(f"{name} did not get ready")
        rclpy.spin_until_future_complete(watcher, client.call_async(Trigger.Request()), timeout_sec=TIMEOUT_S)
        return perf_counter() - began
    finally:
        process.send_signal(signal.SIGINT)
        process.wait()
        watcher.destroy_node()


def _parameters(name: str, folder: Path) -> list[str]:
    if name == "trajectory":
        plan_file.save(folder / "plan.json", flight_blocks.plan_of(library.load(SCENARIO)))
        return [f"plan:={folder / 'plan.json'}"]
    if name == "bag_record":
        return [f"bag:={folder / f'bag_{perf_counter()}'}"]
    return ["autostart:=false"] if name == "simulator" else []
