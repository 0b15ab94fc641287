"""A flight over two hosts (network namespaces) gives the numbers of one. Skipped where none can be made."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import yaml
from two_hosts import ADDRESS, DESK, ROOM

from q2q_model.model_files.find_model import find_model
from q2q_sim.flight_bag.recorded_trace import trace_in
from q2q_sim.loop.closed_loop import FlightOptions
from q2q_sim.loop.closed_loop import fly as fly_pure
from q2q_sim.node_flights.flight_nodes import node_specs
from q2q_sim.node_flights.flight_request import FlightRequest
from q2q_sim.processes.processes import find_executable
from q2q_sim.scenarios import library

SHORT = str(Path(__file__).parents[1] / "scenarios" / "short_room.yaml")
SEED = 3
SERVER = "fast-discovery-server"
PORT = "11811"
"""Where the discovery server listens, on the host of the room."""
TIMEOUT_S = 300.0
AT_THE_DESK = ("mocap_filter", "interference", "trajectory", "replanner", "pid")
IN_THE_ROOM = """
import sys
from pathlib import Path
from q2q_sim.ros.flight_director import FlightDirector
from q2q_sim.node_flights.flight_nodes import node_specs
from q2q_sim.node_flights.flight_request import FlightRequest, load_scenario
from q2q_sim.processes.processes import Processes
scenario, mode, seed, folder = sys.argv[1], sys.argv[2], int(sys.argv[3]), Path(sys.argv[4])
request = FlightRequest(scenario, mode, seed=seed)
specs = node_specs(load_scenario(request), request, folder, folder / "bag")
names = [spec.executable for spec in specs]
with Processes(folder) as processes:
    for spec in (specs[0], specs[-1]):
        processes.start(spec)
    with FlightDirector(processes.check) as director:
        director.wait_connected(names, 250.0)
        director.start()
        director.wait_summary(lambda _: None)
        director.wait_drained([*names[1:], names[0]])
"""


@pytest.mark.usefixtures("hosts")
def test_a_flight_over_two_hosts_gives_the_numbers_of_one(tmp_path: Path) -> None:
    request = FlightRequest(SHORT, seed=SEED)
    _fly_apart(request, tmp_path, {})
    _assert_numbers_of_one(request, tmp_path)


@pytest.mark.usefixtures("hosts")
def test_a_discovery_server_stands_in_for_multicast(tmp_path: Path) -> None:
    program = shutil.which(SERVER)
    if program is None:
        pytest.skip(f"the program {SERVER} is not on the path")
    words = ["ip", "netns", "exec", ROOM, program, "-i", "0", "-l", ADDRESS, "-p", PORT]
    request = FlightRequest(SHORT, seed=SEED)
    with subprocess.Popen(words, stdout=subprocess.DEVNULL) as server:
        try:
            _fly_apart(request, tmp_path, {"ROS_DISCOVERY_SERVER": f"{ADDRESS}:{PORT}"})
        finally:
            server.terminate()
    _assert_numbers_of_one(request, tmp_path)


def _fly_apart(request: FlightRequest, folder: Path, more: dict[str, str]) -> None:
    """Fly with the simulator and the recorder on one host, and the control loop on the other."""
    scenario = library.load(request.scenario)
    env = {name: value for name, value in os.environ.items() if name != "ROS_LOCALHOST_ONLY"}
    env |= {"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET", "ROS_DOMAIN_ID": "77"} | more
    env["FASTDDS_BUILTIN_TRANSPORTS"] = "UDPv4"  # namespaces share memory, hosts do not
    asked = [request.scenario, request.mode, str(request.seed)]
    (folder / "desk").mkdir()
    specs = [
        spec
        for spec in node_specs(scenario, request, folder / "desk", folder / "unused")
        if spec.executable in AT_THE_DESK
    ]
    working_folder = []
    for spec in specs:
        file = folder / "desk" / f"{spec.executable}.yaml"
        plain = {
            key: list(value) if isinstance(value, tuple) else value for key, value in spec.parameters.items()
        }
        file.write_text(yaml.safe_dump({"/**": {"ros__parameters": _nested(plain)}}))
        program = str(find_executable(spec.package, spec.executable))
        words = ["ip", "netns", "exec", DESK, program, "--ros-args", "--params-file", str(file)]
        working_folder.append(subprocess.Popen(words, env=env))
    try:
        (folder / "room").mkdir()
        words = ["ip", "netns", "exec", ROOM, sys.executable, "-c", IN_THE_ROOM]
        subprocess.run([*words, *asked, str(folder / "room")], env=env, check=True, timeout=TIMEOUT_S)
    finally:
        for process in working_folder:
            process.terminate()
        for process in working_folder:
            process.wait(TIMEOUT_S)


def _assert_numbers_of_one(request: FlightRequest, folder: Path) -> None:
    scenario = library.load(request.scenario)
    options = FlightOptions(
        mode=request.options.mode, seed=request.seed, model=find_model(scenario.model).interaction
    )
    pure = fly_pure(scenario, options)
    found = trace_in(folder / "room" / "bag")
    # sums in another order round otherwise: the bound of test_lockstep_flight
    np.testing.assert_allclose(found.true_pos, pure.true_pos, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(found.thrust, pure.thrust, rtol=0.0, atol=1e-9)


def _nested(flat: dict[str, object]) -> dict[str, object]:
    """Return parameters `a.b` as {a: {b: ...}}; an empty list, whose type ROS cannot tell, is left out."""
    made: dict[str, object] = {}
    for key, value in flat.items():
        group, dot, rest = key.partition(".")
        if value == []:
            continue
        if dot:
            inner = made.setdefault(group, {})
            assert isinstance(inner, dict)
            inner[rest] = value
        else:
            made[key] = value
    return made
