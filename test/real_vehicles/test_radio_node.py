"""The node `radio` as a user starts it: two vehicles over cflib and UDP, live, from start to landing."""

import os
import signal
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from time import monotonic

import numpy as np
import pytest

pytest.importorskip("cflib", reason="cflib is not installed: requirements/radio.txt has it")
pytest.importorskip("q2q_msgs", reason="the workspace is not built")

import rclpy
from rclpy.client import Client
from rclpy.node import Node
from std_srvs.srv import Empty, Trigger

from q2q_control.radio.link import cflib_link
from q2q_control.radio.link.firmware_params import (
    POSE_STD,
    firmware_params,
    first_difference,
    left_out_lines,
    settings_lines,
)
from q2q_control.radio.radio_params import RadioNodeParams
from q2q_model.ros.node.bounded_spin import make_executor
from q2q_model.ros.topics.messages import MESSAGES
from q2q_model.ros.topics.qos import EVERY_TICK
from q2q_model.signals.cdr.cdr_reader import decode
from q2q_model.signals.values import SwarmState
from q2q_model.trajectory import plan_file
from q2q_sim.loop import flight_blocks
from q2q_sim.node_flights.scenario_node_parameters import (
    controller_node_parameters,
    filter_node_parameters,
    replanner_node_parameters,
)
from q2q_sim.processes.domain import own_domain
from q2q_sim.processes.processes import NodeSpec, Processes
from q2q_sim.scenarios import library

SCENARIO = "table6"
LIVE = {"live": True}
TIMEOUT_S = 120.0
"""All nodes of a flight on a busy machine [s]."""
PATIENT = {
    "pid": {"land_after_s": 60.0, "cut_after_s": 120.0},
    "radio": {"command_timeout_land_s": 60.0, "command_timeout_stop_s": 120.0, "setpoint_timeout_s": 60.0},
}
"""Parameters with which no node lands because another stood still on a busy machine."""
SERVICES = {"simulator/start": Trigger, "radio/start": Trigger, "radio/land": Trigger, "all/emergency": Empty}
AGAIN_S = 2.0
"""A question that is not answered for so long is asked again [s]."""


def first_port(domain: int) -> int:
    """Return the first of two UDP ports of a reserved domain, below those that the system hands out."""
    return 20000 + 2 * domain


class _Watcher:
    """Watch the flight from a node of its own."""

    def __init__(self, processes: Processes) -> None:
        rclpy.init()
        self._node = Node("watcher")
        self._executor = make_executor()
        self._executor.add_node(self._node)
        self.processes = processes
        self.check = processes.check
        self.fastest_fall = 0.0
        self.truth: SwarmState | None = None
        kind = MESSAGES[SwarmState]
        self._node.create_subscription(kind, "truth", self._on_truth, EVERY_TICK, raw=True)
        self._clients: dict[str, Client] = {
            name: self._node.create_client(kind, name) for name, kind in SERVICES.items()
        }

    def close(self) -> None:
        """Leave the graph."""
        self._executor.shutdown()
        self._node.destroy_node()
        rclpy.try_shutdown()

    def call(self, service: str) -> Trigger.Response:
        """Call one of SERVICES."""
        client = self._clients[service]
        self.until(client.service_is_ready, service)
        future = client.call_async(SERVICES[service].Request())
        self.until(future.done, service)
        return future.result()

    def wait_ready(self, node: str) -> None:
        """Ask a node until it answers: its answer is lost where it has not found the one who asks yet.

        Discovery is in order: a node that answers has found the clients of SERVICES, which were made before.
        """
        client = self._node.create_client(Trigger, f"{node}/ready")
        self.until(client.service_is_ready, node)
        answers = [client.call_async(Trigger.Request())]
        asked = [monotonic()]

        def answered() -> bool:
            if monotonic() > asked[-1] + AGAIN_S:
                answers.append(client.call_async(Trigger.Request()))
                asked.append(monotonic())
            return any(answer.done() for answer in answers)

        self.until(answered, f"{node}/ready")

    def until(self, reached: Callable[[], bool], what: str) -> None:
        deadline = monotonic() + TIMEOUT_S
        while not reached():
            self.check()
            assert monotonic() < deadline, f"{what}: not within {TIMEOUT_S} s"
            self._executor.spin_once(timeout_sec=0.05)

    def granted(self, service: str) -> bool:
        return bool(self.call(service).success)

    def pass_time(self, seconds: float) -> None:
        """Wait until the room's time has moved on."""
        begin = self.now()
        self.until(lambda: self.now() >= begin + seconds, f"{seconds} s of flight")

    def now(self) -> float:
        return -1.0 if self.truth is None else self.truth.t

    def _on_truth(self, data: bytes) -> None:
        self.truth = decode(data, SwarmState)
        self.fastest_fall = max(self.fastest_fall, float(-self.truth.vel[:, 2].min()))

    def on_the_ground(self) -> bool:
        return self.truth is not None and float(self.truth.pos[:, 2].max()) == 0.0

    def fly(self) -> None:
        """Start the room and the vehicles, and fly for 3 s."""
        assert self.granted("simulator/start")
        self.until(lambda: self.granted("radio/start"), "radio/start")
        self.pass_time(3.0)


def specs(folder: Path, domain: int, more: Mapping[str, Mapping[str, float]]) -> list[NodeSpec]:
    scenario = library.load(SCENARIO)
    options = flight_blocks.BlockChoices()
    plan, port = folder / "plan.json", first_port(domain)
    plan_file.save(plan, flight_blocks.plan_of(scenario))
    uris = tuple(f"udp://127.0.0.1:{port + k}" for k in range(2))
    room = {"scenario": SCENARIO, "autostart": False, "crtp": True, "crtp_port": port, "crtp_start": "air"}
    radio = {
        "vehicles": scenario.names,
        "uris": uris,
        "vehicle": scenario.vehicle.name,
        "firmware_params": ("locSrv.extPosStdDev=0.002",),  # read back before the start
        **more.get("radio", {}),
    }
    return [
        NodeSpec("q2q_model", "mocap_filter", filter_node_parameters(scenario)),
        NodeSpec("q2q_model", "interference", {"model": scenario.model}),
        NodeSpec("q2q_planner", "trajectory", {"plan": str(plan), "start": 0.0}),
        NodeSpec("q2q_planner", "replanner", replanner_node_parameters(scenario, options)),
        NodeSpec(
            "q2q_control",
            "pid",
            controller_node_parameters(scenario, options) | LIVE | dict(more.get("pid", {})),
        ),
        NodeSpec("q2q_sim", "simulator", room),
        NodeSpec("q2q_control", "radio", radio),
    ]


@pytest.fixture
def watcher(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[_Watcher]:
    with own_domain() as domain, Processes(tmp_path) as processes:
        demanded = specs(tmp_path, domain, request.param)
        for spec in demanded:
            processes.start(spec)
        made = _Watcher(processes)
        try:
            for spec in demanded:
                made.wait_ready(spec.executable)
            yield made
        finally:
            made.close()


@pytest.mark.parametrize("watcher", [PATIENT], ids=["patient"], indirect=True)
def test_the_radio_node_starts_flies_and_lands_two_vehicles_live(watcher: _Watcher) -> None:
    refusal = watcher.call("radio/start")
    assert not refusal.success  # offline, or without a state: the room stands still
    assert watcher.granted("simulator/start")
    watcher.until(lambda: watcher.granted("radio/start"), "radio/start")
    assert "the step is flight" in watcher.call("radio/start").message
    watcher.pass_time(3.0)
    assert watcher.truth is not None
    assert watcher.truth.pos[0, 2] == pytest.approx(1.5, abs=0.1)
    assert watcher.truth.pos[1, 2] == pytest.approx(2.0, abs=0.1)
    watcher.until(lambda: watcher.granted("radio/land"), "radio/land")  # again, where the room falls behind
    watcher.until(watcher.on_the_ground, "landing")


@pytest.mark.parametrize("watcher", [{}], ids=["as shipped"], indirect=True)
def test_a_controller_that_is_killed_in_flight_leaves_its_vehicles_to_land(watcher: _Watcher) -> None:
    watcher.fly()
    watcher.check = lambda: None  # a node dies, as it must
    os.kill(watcher.processes.pid("pid"), signal.SIGKILL)
    watcher.fastest_fall = 0.0
    assert watcher.truth is not None
    place = watcher.truth.pos[:, :2].copy()
    watcher.until(watcher.on_the_ground, "landing")
    # the firmware's own limit, and a little overshoot; a drop from 2 m arrives with 6.3 m/s
    assert watcher.fastest_fall < 1.2
    assert watcher.truth is not None
    # below where they were: 0.08 m/s for the second before the landing, and as much again to come to rest
    np.testing.assert_allclose(watcher.truth.pos[:, :2], place, atol=0.25)


@pytest.mark.parametrize("watcher", [PATIENT], ids=["patient"], indirect=True)
def test_an_emergency_stops_the_vehicles_of_a_radio_for_good(watcher: _Watcher) -> None:
    watcher.fly()
    watcher.call("all/emergency")
    watcher.until(watcher.on_the_ground, "falling")
    assert watcher.fastest_fall > 4.0  # from 1.5 and 2 m with the motors off
    watcher.until(lambda: "locked: restart it" in watcher.call("radio/start").message, "refusal")


def test_a_node_without_cflib_says_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "cflib.crtp", None)
    with pytest.raises(ValueError, match="cflib is not installed: `pip install cflib"):
        cflib_link.CflibLink("cf1", "udp://127.0.0.1:1", {})


def test_parameters_of_the_node_are_checked() -> None:
    with pytest.raises(ValueError, match="2 vehicles and 1 uris"):
        RadioNodeParams(vehicles=("cf1", "cf2"), uris=("udp://x",))
    assert firmware_params(("locSrv.extPosStdDev = 1e-3",), "setpoint") == {
        "stabilizer.controller": 2.0, "locSrv.extPosStdDev": 1e-3,
    }  # fmt: skip
    assert firmware_params(("locSrv.extPosStdDev=1e-3",), "command", poses=True) == {
        **POSE_STD, "stabilizer.controller": 1.0, "locSrv.extPosStdDev": 1e-3,
    }  # fmt: skip
    of_file = {
        "stabilizer.controller": 1.0,
        "locSrv.extPosStdDev": 2e-3,
        "ctrlMel.mass": 0.045,
        "ctrlMel.kp_z": 2.5,
    }
    assert firmware_params(("ctrlMel.mass=0.05",), "setpoint", poses=True, of_file=of_file) == {
        **POSE_STD, **of_file, "stabilizer.controller": 2.0, "ctrlMel.mass": 0.05,
    }  # fmt: skip
    mellingers = of_file | {"stabilizer.controller": 2.0}
    assert firmware_params((), "command", of_file=mellingers) == of_file  # attitudes are for the PID's loop
    assert firmware_params(("stabilizer.controller=2",), "command", of_file=of_file) == mellingers
    assert settings_lines({"cf1": {"a.b": 4294967295.0, "c.d": 1e-3}}) == [
        "firmware_params of cf1: a.b=4294967295, c.d=0.001"
    ]
    [line] = settings_lines({f"cf{k}": {"a.b": 1.0} for k in range(30)})
    assert line.endswith(", cf19, and 10 more: a.b=1")
    with pytest.raises(ValueError, match=r"'nonsense'; must be group\.name=value"):
        firmware_params(("nonsense",), "command")


@pytest.mark.parametrize(
    ("entries", "mode", "said"),
    [
        ((), "command", "is ignored (2 of cf2, 6 of cf3): 1 is set, by the mode"),
        ((), "setpoint", "is ignored (1 of cf1): 2 is set"),  # 6 is the firmware app's
        (("stabilizer.controller=5",), "command", "is ignored (1 of cf1, 2 of cf2, 6 of cf3): 5 is set"),
    ],
)
def test_a_controller_of_the_file_that_is_not_set_is_logged(
    entries: tuple[str, ...], mode: str, said: str
) -> None:
    files = {f"cf{k + 1}": {"stabilizer.controller": value} for k, value in enumerate((1.0, 2.0, 6.0))}
    files["cf4"] = {}
    params = {name: firmware_params(entries, mode, of_file=one) for name, one in files.items()}
    (line,) = left_out_lines(files, params)
    assert line.startswith(f"stabilizer.controller of crazyflies {said}")
    named = {"cf1": files["cf1"]}
    assert left_out_lines(named, {"cf1": firmware_params((), "command", of_file=named["cf1"])}) == []


def test_a_parameter_that_a_vehicle_does_not_hold_is_named_with_both_values() -> None:
    demanded = firmware_params(("locSrv.extPosStdDev=1e-3",), "setpoint")
    held = {"stabilizer.controller": 2.0, "locSrv.extPosStdDev": float(np.float32(1e-3))}
    assert not first_difference(demanded, held)
    assert "its stabilizer.controller is 1, expected 2" in first_difference(
        demanded, held | {"stabilizer.controller": 1.0}
    )
    assert "its locSrv.extPosStdDev is nan, expected 0.001" in first_difference(
        demanded, {"stabilizer.controller": 2.0}
    )
