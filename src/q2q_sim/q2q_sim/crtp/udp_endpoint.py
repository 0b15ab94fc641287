"""UDP ports of a fleet on loopback: one for each vehicle, framed as in cflib's UDP driver.

A thread receives datagrams, at most BURST from each port in turn, so that a flood on one port starves neither
the others nor the room. The room's loop calls `fly`; a lock separates both.
"""

import selectors
import socket
import threading
from collections.abc import Callable
from dataclasses import dataclass
from time import monotonic
from typing import Self

from q2q_model.counted import counted
from q2q_model.node.loopback import LOOPBACK
from q2q_model.signals.values import Array
from q2q_sim.crtp.client_warnings import ClientWarnings
from q2q_sim.crtp.fleet import Fleet, Sent
from q2q_sim.crtp.loopback_ports import opened_ports
from q2q_sim.crtp.packets.packet import is_stream
from q2q_sim.crtp.vehicle import CrtpVehicle
from q2q_sim.link.shared_radios import DelayLine, SharedRadioParams, SharedRadios

BURST = 32
"""Datagrams received from one port before the next one's turn."""
DATAGRAM_MAX = 64
"""Bytes read of a datagram; longer than a packet, so that oversized ones are refused."""
WAKE_S = 0.2
"""Longest sleep of the thread [s]."""

Address = tuple[str, int]


@dataclass(slots=True)
class Traffic:
    """Packet counts."""

    received: int = 0
    sent: int = 0
    dropped: int = 0
    """Lost by the link model or a full socket."""


class CrtpEndpoint:
    """Sockets of a fleet; a context manager."""

    def __init__(
        self,
        fleet: Fleet,
        base_port: int,
        link: SharedRadioParams,
        *,
        seed: int = 0,
        now: Callable[[], float] = monotonic,
    ) -> None:
        """Open the ports base_port, base_port + 1, ...; with 0 the system chooses each.

        Raises:
            ValueError: there are not as many ports from base_port on.
            OSError: a port is taken, naming it.
        """
        self.traffic = Traffic()
        self._fleet = fleet
        self._warnings = ClientWarnings(fleet.vehicles)
        self._now = now
        self._radios = SharedRadios(link, len(fleet.vehicles), seed)
        self._up: DelayLine[tuple[int, Address, bytes]] = DelayLine()
        self._down: DelayLine[tuple[int, Address, bytes]] = DelayLine()
        self._lock = threading.Lock()
        self._ended = threading.Event()
        self._sockets = opened_ports([one.name for one in fleet.vehicles], base_port)
        self._wake_reader, self._wake_writer = socket.socketpair()
        self._thread = threading.Thread(target=self._run, name="crtp", daemon=True)
        self._thread.start()

    @property
    def uris(self) -> tuple[str, ...]:
        """Return the URI of every vehicle for clients."""
        return tuple(f"udp://{LOOPBACK}:{one.getsockname()[1]}" for one in self._sockets)

    def diagnostics(self) -> dict[str, str]:
        """Return the packet counts, and each vehicle's clients and refusals, as text."""
        passed = self.traffic
        packets = f"{passed.received} in, {passed.sent} out, {passed.dropped} dropped"
        return {"crtp_packets": packets} | {
            f"crtp_{one.name}": _clients_of(one) for one in self._fleet.vehicles
        }

    def warnings(self) -> str:
        """Return what the vehicles have refused of clients since the last call; empty if nothing."""
        return self._warnings.poll()

    def __enter__(self) -> Self:
        """Return the endpoint."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close the ports."""
        self.close()

    def close(self) -> None:
        """End the thread and close the ports."""
        self._ended.set()
        self._wake_writer.send(b"\0")
        self._thread.join()
        for one in (*self._sockets, self._wake_reader, self._wake_writer):
            one.close()

    def fly(self, drive: Array) -> None:
        """Advance the fleet by one tick (Fleet.fly) and send the datagrams due to clients."""
        with self._lock:
            self._fleet.fly(drive)
            for one in self._fleet.outgoing():
                self._send(one)
            self._deliver()

    def _run(self) -> None:
        with selectors.DefaultSelector() as selector:
            selector.register(self._wake_reader, selectors.EVENT_READ)
            for row, one in enumerate(self._sockets):
                selector.register(one, selectors.EVENT_READ, data=row)
            while not self._ended.is_set():
                ready = selector.select(self._sleep())
                for key, _ in ready:
                    if isinstance(key.data, int):
                        self._receive(key.data)
                with self._lock:
                    self._deliver()

    def _sleep(self) -> float:
        with self._lock:
            nexts = [one.next_arrival for one in (self._up, self._down)]
        waits = [one - self._now() for one in nexts if one is not None]
        return min(WAKE_S, max(min(waits, default=WAKE_S), 0.0))

    def _receive(self, row: int) -> None:
        for _ in range(BURST):
            try:
                datagram, client = self._sockets[row].recvfrom(DATAGRAM_MAX)
            except OSError:
                return
            with self._lock:
                self.traffic.received += 1
                self._take(row, client, datagram)

    def _take(self, row: int, client: Address, datagram: bytes) -> None:
        arrival = self._radios.arrival(row, self._now(), streamed=is_stream(datagram)) if datagram else None
        if arrival is None:
            self.traffic.dropped += 1
        elif arrival <= self._now():
            self._handle(row, client, datagram)
        else:
            self._up.push(arrival, (row, client, datagram))

    def _handle(self, row: int, client: Address, datagram: bytes) -> None:
        for answer in self._fleet.vehicles[row].handle(datagram, client):
            self._send(Sent(row, client, answer))

    def _send(self, one: Sent) -> None:
        client = one.client
        if not isinstance(client, tuple):
            return
        arrival = self._radios.arrival(one.vehicle, self._now(), streamed=is_stream(one.datagram))
        if arrival is None:
            self.traffic.dropped += 1
        elif arrival <= self._now():
            self._write(one.vehicle, client, one.datagram)
        else:
            self._down.push(arrival, (one.vehicle, client, one.datagram))

    def _deliver(self) -> None:
        for row, client, datagram in self._up.due(self._now()):
            self._handle(row, client, datagram)
        for row, client, datagram in self._down.due(self._now()):
            self._write(row, client, datagram)

    def _write(self, row: int, client: Address, datagram: bytes) -> None:
        try:
            self._sockets[row].sendto(datagram, client)
            self.traffic.sent += 1
        except OSError:  # the client's buffer is full, or the client is gone
            self.traffic.dropped += 1


def _clients_of(vehicle: CrtpVehicle) -> str:
    counts = f"{counted(len(vehicle.clients), 'client')}, {vehicle.refusals.count} refused"
    return f"{counts}: {vehicle.refusals.last}" if vehicle.refusals.last else counts
