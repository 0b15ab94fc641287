"""CRTP server of one vehicle: datagrams in, datagrams out, for any number of clients.

Each client has its own log blocks and is kept until it has been silent for SILENCE_MS; setpoints and
parameters are shared, and the last one wins, as with two radios on one address. Every client gets a console
message when another appears. Malformed, short, non-finite or unknown packets are refused: counted with the
reason, without effect.

The firmware locks after an emergency stop or a watchdog's shutdown until a reboot. Here it reboots when all
clients have gone, or when one sends the radio's reboot command (0xFF, 0xFE, 0x03 or 0xF0). The command
0x01 or 0x02 turns the firmware off until then.
"""

from collections.abc import Callable, Hashable
from dataclasses import dataclass, field

from q2q_sim.crtp.packets.packet import MAX_DATA, NULL, MalformedError, Packet, Port, datagram_of, packet_of
from q2q_sim.crtp.ports import (
    commander_generic,
    commander_high_level,
    commander_rpyt,
    link_service,
    localization,
    memory,
    parameters,
    parameters_misc,
    platform,
    supervisor_port,
)
from q2q_sim.crtp.ports.log_blocks import LogBlocks
from q2q_sim.firmware.firmware import Firmware
from q2q_sim.firmware.supervisor.rules import State

SILENCE_MS = 1000
"""RADIO_ACTIVITY_TIMEOUT_MS of the firmware, after which logs to a client end."""
MOST_CLIENTS = 8
"""Largest number of clients; a new one replaces the one silent for longest."""
RADIO, ALL_OFF, POWER_DOWN, POWER_UP, RESET = 0xFE, 0x01, 0x02, 0x03, 0xF0
"""cflib: utils/power_switch.py."""
LOCAL = "local"
"""Client in the same process, without a network."""


@dataclass(slots=True)
class _Session:
    """State of a client."""

    last_packet_ms: int
    logs: LogBlocks = field(default_factory=LogBlocks)


@dataclass(slots=True)
class Refusals:
    """Counter of refused packets."""

    count: int = 0
    last: str = ""

    def note(self, reason: str) -> None:
        """Count one."""
        self.count, self.last = self.count + 1, reason


_SERVICES: dict[int, Callable[[Firmware, Packet], list[Packet]]] = {
    Port.SETPOINT: commander_rpyt.serve,
    Port.MEMORY: memory.serve,
    Port.LOCALIZATION: localization.serve,
    Port.GENERIC: commander_generic.serve,
    Port.HIGH_LEVEL: commander_high_level.serve,
    Port.SUPERVISOR: supervisor_port.serve,
    Port.PLATFORM: platform.serve,
}


class CrtpVehicle:
    """Firmware of one vehicle and its clients."""

    def __init__(self, name: str, firmware: Firmware) -> None:
        self.name = name
        self.firmware = firmware
        self.refusals = Refusals()
        self.displaced = 0
        """Clients that got nothing more because another came."""
        self._off = False
        self._sessions: dict[Hashable, _Session] = {}

    @property
    def clients(self) -> tuple[Hashable, ...]:
        """Return the active clients."""
        return tuple(self._sessions)

    def handle(self, datagram: bytes, client: Hashable = LOCAL) -> list[bytes]:
        """Execute one datagram of a client; return the datagrams that answer it."""
        if datagram == NULL:
            return [NULL]
        if len(datagram) > 2 and datagram[0] >= 0xF0 and datagram[1] == RADIO:
            return self._radio_command(datagram)
        if self._off:
            return []
        try:
            answers = self._serve(packet_of(datagram), client)
        except MalformedError as refusal:
            self.refusals.note(str(refusal))
            return []
        return [datagram_of(answer) for answer in answers]

    def step(self) -> list[tuple[Hashable, bytes]]:
        """Return the datagrams due to clients now: logs and console messages."""
        self._forget_silent()
        words, self.firmware.console = self.firmware.console, ""
        console = [datagram_of(one) for one in _console(words)]
        sent: list[tuple[Hashable, bytes]] = []
        for client, session in self._sessions.items():
            sent += [(client, word) for word in console]
            sent += [(client, datagram_of(block)) for block in session.logs.due(self.firmware)]
        return sent

    def _serve(self, packet: Packet, client: Hashable) -> list[Packet]:
        session = self._session(client)
        self.firmware.received += 1
        if packet.port == Port.LINK:
            return link_service.serve(packet)
        if packet.port == Port.LOG:
            return session.logs.serve(packet, self.firmware.now_ms)
        if packet.port == Port.PARAM:
            serve = parameters_misc.serve if packet.channel == parameters_misc.CHANNEL else parameters.serve
            return serve(self.firmware, packet)
        if packet.port in _SERVICES:
            return _SERVICES[packet.port](self.firmware, packet)
        raise MalformedError(f"port {packet.port}: not served")

    def _session(self, client: Hashable) -> _Session:
        known = self._sessions.get(client)
        now = self.firmware.now_ms
        if known is not None:
            known.last_packet_ms = now
            return known
        if len(self._sessions) >= MOST_CLIENTS:
            del self._sessions[min(self._sessions, key=lambda one: self._sessions[one].last_packet_ms)]
            self.displaced += 1
            self.firmware.console += "Q2Q: the client silent for longest gets nothing more\n"
        self._sessions[client] = _Session(now)
        if len(self._sessions) > 1:
            self.firmware.console += f"Q2Q: {len(self._sessions)} clients; all may command\n"
        return self._sessions[client]

    def _forget_silent(self) -> None:
        limit = self.firmware.now_ms - SILENCE_MS
        silent = [one for one, session in self._sessions.items() if session.last_packet_ms < limit]
        for client in silent:
            del self._sessions[client]
        locked = self.firmware.supervisor.state == State.LOCKED
        if locked and not self._sessions and float(self.firmware.rows.state[2]) <= 0.0:
            self.firmware.boot()

    def _radio_command(self, datagram: bytes) -> list[bytes]:
        if datagram[2] in {ALL_OFF, POWER_DOWN, POWER_UP, RESET}:
            self._off = datagram[2] in {ALL_OFF, POWER_DOWN}
            self.firmware.boot()
            self._sessions.clear()
        return [NULL]


def _console(words: str) -> list[Packet]:
    data = words.encode("ascii", "replace")
    return [Packet(Port.CONSOLE, 0, data[at : at + MAX_DATA]) for at in range(0, len(data), MAX_DATA)]
