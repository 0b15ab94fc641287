"""Control of a fleet in simulated time by cflib's own encoders, without network, threads or clock.

`Wire` replaces the Crazyflie object of cflib's Commander, HighLevelCommander, Localization and Supervisor;
`CflibFleet` is such a fleet, which flies by its own firmware, tick by tick.
"""

from collections.abc import Callable, Hashable
from typing import Protocol

import numpy as np

from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import CRAZYFLIE_2_0
from q2q_sim.air.wake_laws import WakeLaw
from q2q_sim.crtp.fleet import Fleet, Sent
from q2q_sim.crtp.ports.link_service import ECHO_REQUEST
from q2q_sim.crtp.vehicle import LOCAL
from q2q_sim.firmware.commander.setpoint import Setpoint
from q2q_sim.firmware.firmware import Firmware
from q2q_sim.firmware.firmware_build import Build
from q2q_sim.plant.swarm import Swarm

STILL = (0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0)
"""Still air and rotors of gain 1."""
TICKS_PER_S = 100


class SentPacket(Protocol):
    """Interface of cflib's CRTPPacket."""

    header: int
    data: bytearray


class Wire:
    """Packet sink with the interface of cflib's Crazyflie; keeps packets and answers."""

    def __init__(self, deliver: Callable[[bytes], list[bytes]]) -> None:
        self._deliver = deliver
        self.sent: list[bytes] = []
        self.answers: list[bytes] = []
        self.link = self
        self.platform = self
        self.needs_resending = False
        self.version = 12
        """CRTP protocol version for the encoders."""

    def get_protocol_version(self) -> int:
        """Return the version of the protocol."""
        return self.version

    def add_port_callback(self, _: int, __: object) -> None:
        """Accept a listener; answers are kept, not delivered."""

    def add_callback(self, _: object) -> None:
        """Accept a listener; connections do not change here."""

    @property
    def disconnected(self) -> "Wire":
        """Return the caller for listeners to the end of the connection."""
        return self

    @property
    def connection_requested(self) -> "Wire":
        """Return the caller for listeners to its start."""
        return self

    def send_packet(self, packet: SentPacket, **_: object) -> None:
        """Deliver a packet at once."""
        datagram = bytes([packet.header]) + bytes(packet.data)
        self.sent.append(datagram)
        self.answers += self._deliver(datagram)


class CflibFleet:
    """Crazyflies 2.0 that fly by their own firmware, commanded by `wire`."""

    def __init__(self, start: Array, wake: WakeLaw = WakeLaw.NONE, build: Build | None = None) -> None:
        """Place vehicles cf1, cf2, ... at rest at `start` (n, 4): x, y, z [m], yaw [rad]."""
        names = tuple(f"cf{k + 1}" for k in range(len(start)))
        self.swarm = Swarm(names, CRAZYFLIE_2_0, np.array(start, dtype=np.float64), wake)
        self.fleet = Fleet(self.swarm, CRAZYFLIE_2_0, build or Build())
        self.drive = np.tile(STILL, (len(start), 1))
        self.out: list[Sent] = []
        """Datagrams to clients since the start."""

    def wire(self, vehicle: int = 0, client: Hashable = LOCAL) -> Wire:
        """Return the object that cflib's encoders use as a Crazyflie."""
        return Wire(lambda datagram: self.fleet.vehicles[vehicle].handle(datagram, client))

    def firmware(self, vehicle: int = 0) -> Firmware:
        """Return the firmware of a vehicle."""
        return self.fleet.vehicles[vehicle].firmware

    def pos(self, vehicle: int = 0) -> Array:
        """Return the true position of a vehicle [m], world, (3,)."""
        return np.array(self.swarm.state[vehicle, :3])

    def fly(self, seconds: float, each: Callable[[float], None] = lambda _: None) -> None:
        """Advance time; `each` is called with the time [s] before every tick."""
        for _ in range(round(seconds * TICKS_PER_S)):
            each(self.firmware().seconds)
            self.fleet.fly(self.drive)
            self.out += self.fleet.outgoing()

    def hold(self, setpoint: Setpoint) -> Callable[[float], None]:
        """Return a function that sends a setpoint to all before every tick and keeps the client alive."""

        def each(_: float) -> None:
            for vehicle in self.fleet.vehicles:
                vehicle.handle(ECHO_REQUEST)
                vehicle.firmware.accept(setpoint)

        return each
