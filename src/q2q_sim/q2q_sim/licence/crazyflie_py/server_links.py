"""Links of Crazyswarm2's server to the vehicles.

A call hands its packet to the server and returns. To one vehicle, the radio repeats it until the vehicle
acknowledges: while no packet passes, packets wait. A broadcast is repeated BROADCAST_S long without
acknowledgement: a vehicle whose link is silent all that time does not get it. The repetitions that do arrive
are one here, for each has the effect of the first. All packets that arrive do so in the order of the calls.
The server lives on when the program has ended.
"""

import threading
from collections import deque
from collections.abc import Sequence

from q2q_sim.crtp.packets.packet import Packet, datagram_of
from q2q_sim.licence.program_process.link_host import POLL_S, LinkHost
from q2q_sim.licence.room.licence_room import PACKET_S, OpenLink, Sender

CALL_S = 2e-5
"""Time that a call takes the program [s]: rclpy 7.1.6 publishes a pose in 24 us, calls a service in 16 us."""
BROADCAST_S = 0.015
"""15 repetitions, 1 ms apart [s]: crazyflies.yaml, all.broadcasts."""
Waiting = tuple[bytes, Sender]


class ServerLinks:
    """Links to the vehicles of the server."""

    def __init__(self, host: LinkHost, uris: Sequence[str]) -> None:
        self._host = host
        self._links = [OpenLink(host.vehicle_of(uri)) for uri in uris]
        self._waiting: list[deque[Waiting]] = [deque() for _ in uris]
        for link in self._links:
            host.room.keep_alive(link)
        threading.Thread(target=self._serve, daemon=True).start()

    @property
    def now(self) -> float:
        """Return the time [s]."""
        return self._host.scheduler.now

    def row(self, number: int) -> int:
        """Return the vehicle's row in the room."""
        return self._links[number].vehicle

    def send(self, number: int, packet: Packet) -> None:
        """Send a packet to a vehicle by a call of the program."""
        self._host.scheduler.resume()
        self._host.room.opened.append(self._links[number].vehicle)
        self._enqueue(number, packet, self._host.sender)
        self._host.scheduler.spend(CALL_S)

    def broadcast(self, packet: Packet) -> None:
        """Send a packet to all vehicles at once by a call of the program."""
        self._host.scheduler.resume()
        now, sender = self.now, self._host.sender
        for number, link in enumerate(self._links):
            if self._host.room.silent_until(link.vehicle, now) <= now + BROADCAST_S:
                self._enqueue(number, packet, sender)
        self._host.scheduler.spend(CALL_S)

    def set_up(self, number: int, packet: Packet) -> None:
        """Send a packet of the server's own, and drop the answer."""
        link = self._links[number]
        before = len(link.inbox)
        self._host.room.deliver(link, datagram_of(packet), self.now, Sender(0, closing=False))
        if len(link.inbox) > before:
            link.inbox.pop()

    def ask(self, number: int, packet: Packet) -> None:
        """Send a packet by a call of the program that waits until it has arrived."""
        self.send(number, packet)
        self._host.scheduler.wait(lambda: not self._waiting[number])
        self._host.scheduler.sleep(PACKET_S)

    def received(self, number: int) -> list[bytes]:
        """Return the packets of a vehicle since the last call."""
        inbox = self._links[number].inbox
        packets = list(inbox)
        inbox.clear()
        return packets

    def settle(self, limit: float) -> None:
        """Wait until no packet waits, at most a time [s]."""
        if any(self._waiting):
            self._host.scheduler.wait(lambda: not any(self._waiting), self.now + limit)

    def _enqueue(self, number: int, packet: Packet, sender: Sender) -> None:
        self._waiting[number].append((datagram_of(packet), sender))
        self._release(number)

    def _release(self, number: int) -> None:
        link, waiting = self._links[number], self._waiting[number]
        while waiting and self._host.passes(link):
            datagram, sender = waiting.popleft()
            self._host.room.deliver(link, datagram, self.now, sender)

    def _due(self) -> bool:
        return any(
            waiting and self._host.passes(link)
            for link, waiting in zip(self._links, self._waiting, strict=True)
        )

    def _serve(self) -> None:
        """Poll the vehicles, and send what waits when it passes."""
        while True:
            self._host.scheduler.wait(self._due, self.now + POLL_S)
            for number, link in enumerate(self._links):
                self._release(number)
                if self._host.passes(link):
                    self._host.room.keep_alive(link)
