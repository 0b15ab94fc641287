"""An unmodified cflib Swarm connects, logs, sets parameters, flies and stops: over UDP on loopback, live.

The vehicles' own log packets pace every client (100 a second of the room's time), so nothing here sleeps, and
a slow machine only takes longer.
"""

import signal
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from threading import Event

import pytest

pytest.importorskip("cflib", reason="cflib is not installed: requirements/dev.txt has it")

import cflib.crtp
from cflib.crazyflie import Crazyflie
from cflib.crazyflie.log import LogConfig
from cflib.crazyflie.swarm import Swarm
from cflib.crazyflie.syncCrazyflie import SyncCrazyflie
from cflib.crazyflie.syncLogger import SyncLogger
from cflib.crtp.crtpstack import CRTPPacket, CRTPPort

VARIABLES = ("stateEstimate.x", "stateEstimate.y", "stateEstimate.z", "supervisor.info")
START_S = 180.0
"""A room that has not opened by then will not: the first one compiles for 20 s on a slow machine [s]."""
STILL = (0.0, 0.0, 0.0)
LEVEL = (0.0, 0.0, 0.0, 1.0)
CAN_FLY, LOCKED = 8, 64


@dataclass(frozen=True, slots=True)
class OpenRoom:
    """Room that flies in its own process."""

    process: subprocess.Popen[str]
    uris: tuple[str, ...]


def open_room(scenario: str, *more: str) -> OpenRoom:
    """Return a room once it is ready."""
    process = subprocess.Popen(
        [sys.executable, "-m", "q2q_sim.commands.crtp", scenario, "--port", "0", *more],
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
    )  # fmt: skip
    assert process.stdout is not None
    uris = []
    for line in process.stdout:
        if line.strip() == "ready":
            return OpenRoom(process, tuple(uris))
        uris.append(line.split()[-1])
    raise AssertionError(f"the room ended: {uris}")


def close_room(room: OpenRoom) -> None:
    room.process.send_signal(signal.SIGINT)
    try:
        assert room.process.wait(timeout=60.0) == 0
    finally:
        room.process.kill()


@pytest.fixture(params=["swarm2", "swarm10"])
def room(request: pytest.FixtureRequest) -> Iterator[OpenRoom]:
    opened = open_room(request.param)
    yield opened
    close_room(opened)


def logger(scf: SyncCrazyflie) -> SyncLogger:
    config = LogConfig("place", 10)
    for name in VARIABLES:
        config.add_variable(name)
    return SyncLogger(scf, config)


@dataclass(frozen=True, slots=True)
class Seen:
    """Content of a log packet: position [m] and the supervisor's bits."""

    x: float
    y: float
    z: float
    info: int


class Flight:
    """Flight of one vehicle: every log packet is one step, and none may be missing."""

    def __init__(self, scf: SyncCrazyflie) -> None:
        self.cf = scf.cf
        self._logs = iter(scf.q2q_logger)
        self._last_ms = -1
        self.packets = 0
        self.answers: list[int] = []
        self.cf.add_port_callback(CRTPPort.SETPOINT_HL, self._note_answer)

    def step(self) -> Seen:
        """Return what the next packet says."""
        stamp, values, _ = next(self._logs)
        assert self._last_ms in {-1, stamp - 10}, f"log packets missing: {self._last_ms} to {stamp} ms"
        self._last_ms = stamp
        self.packets += 1
        x, y, z, info = (values[name] for name in VARIABLES)
        return Seen(x, y, z, int(info))

    def until(
        self, reached: Callable[[Seen], bool], packets: int, act: Callable[[], None] = lambda: None
    ) -> None:
        """Step and act until `reached`, for so many packets at most."""
        for _ in range(packets):
            now = self.step()
            if reached(now):
                return
            act()
        raise AssertionError(f"not reached after {packets} packets: {now}, answers {self.answers}")

    def _note_answer(self, packet: CRTPPacket) -> None:
        """Keep what became of a command of the high-level commander: 0 is done."""
        self.answers.append(packet.data[3])


def set_parameter(cf: Crazyflie, name: str, value: int) -> None:
    done = Event()
    group, last = name.split(".")
    cf.param.add_update_callback(group, last, lambda _, now: done.set() if now == str(value) else None)
    cf.param.set_value(name, value)
    assert done.wait(timeout=60.0), name


def fly(scf: SyncCrazyflie) -> None:
    """Take off, go there, stream full states, RPYT setpoints, land, take off again, stop in the air."""
    scf.wait_for_params()
    cf = scf.cf
    set_parameter(cf, "stabilizer.controller", 2)
    # who waits on the ground for 30 s is disarmed, and armed again 0.12 s later
    set_parameter(cf, "supervisor.prefltTimeout", 65535)
    with logger(scf) as log:
        scf.q2q_logger = log
        flight = Flight(scf)
        flight.until(lambda now: bool(now.info & CAN_FLY), 100)
        first = flight.step()
        x0, y0 = first.x, first.y
        cf.high_level_commander.takeoff(0.5, 1.0)
        flight.until(lambda now: now.z > 0.45, 300)
        cf.high_level_commander.go_to(x0 + 0.2, y0, 0.6, 0.0, 1.0)
        flight.until(lambda now: abs(now.x - x0 - 0.2) < 0.03 and now.z > 0.57, 400)

        def hold() -> None:
            cf.commander.send_full_state_setpoint((x0, y0 + 0.2, 0.7), STILL, STILL, LEVEL, 0, 0, 0)

        flight.until(lambda now: abs(now.y - y0 - 0.2) < 0.03 and abs(now.z - 0.7) < 0.03, 400, hold)
        cf.commander.send_setpoint(0.0, 0.0, 0.0, 0)
        for _ in range(30):
            flight.step()
            cf.commander.send_setpoint(0.0, 0.0, 0.0, 40000)
        cf.commander.send_notify_setpoint_stop()
        cf.high_level_commander.land(0.0, 1.0)
        flight.until(lambda now: now.z < 0.02, 400)
        cf.high_level_commander.stop()
        cf.high_level_commander.takeoff(0.5, 1.0)
        flight.until(lambda now: now.z > 0.4, 400)
        cf.supervisor.send_emergency_stop()
        flight.until(lambda now: now.z < 0.02 and bool(now.info & LOCKED), 200)
        assert flight.packets > 300


def test_a_cflib_swarm_connects_logs_sets_parameters_flies_and_stops(room: OpenRoom) -> None:
    cflib.crtp.init_drivers()
    with Swarm(set(room.uris)) as swarm:
        swarm.parallel_safe(fly)
    assert room.process.poll() is None


def test_a_port_that_is_taken_is_named_and_the_room_does_not_open() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
        taken.bind(("127.0.0.1", 0))
        port = taken.getsockname()[1]
        refused = subprocess.run(
            [sys.executable, "-m", "q2q_sim.commands.crtp", "swarm2", "--port", str(port)],
            capture_output=True, text=True, timeout=START_S, check=False,
        )  # fmt: skip
    assert refused.returncode == 1
    assert f"UDP port {port} of cf1 is taken" in refused.stderr
