"""Where the links of a program end: at the vehicles of a LicenceRoom, with the program's place that calls.

A scan for vehicles answers the URIs of `scanned_uris`.
"""

import sys
import traceback
from collections.abc import Callable
from dataclasses import dataclass

from q2q_sim.licence.program_process.cooperative_scheduler import CooperativeScheduler, never
from q2q_sim.licence.room.licence_room import PACKET_S, LicenceRoom, OpenLink, Sender

SCANNED = "radio://0/80/2M/E7E7E7E7"
"""Before the last byte of the address."""
POLL_S = 0.1
"""Time between two polls of a vehicle by its radio [s]."""


@dataclass(frozen=True, slots=True)
class LinkHost:
    """Where the links of a program end."""

    room: LicenceRoom
    scheduler: CooperativeScheduler
    program: str
    """File of the program, as its frames name it."""
    vehicle_of: Callable[[str], int]
    """Return the vehicle of a URI."""
    scanned: tuple[str, ...]
    """URIs that a scan answers."""

    @property
    def sender(self) -> Sender:
        """Return the line of the program that has called, 0 if none has, and whether it closes a link."""
        closing = False
        for frame, line in traceback.walk_stack(sys._getframe()):  # noqa: SLF001
            if frame.f_code.co_filename == self.program:
                return Sender(line, closing)
            closing = closing or frame.f_code.co_name == "close_link"
        return Sender(0, closing)

    def passes(self, link: OpenLink) -> bool:
        """Return whether packets to a vehicle pass now."""
        return self.room.silent_until(link.vehicle, self.scheduler.now) <= self.scheduler.now

    def send(self, link: OpenLink, datagram: bytes) -> None:
        """Send a packet to a vehicle; returns after the time that it takes."""
        self.scheduler.resume()
        passes = self.room.silent_until(link.vehicle, self.scheduler.now)
        if passes == float("inf"):
            return
        if passes > self.scheduler.now:
            self.scheduler.wait(never, passes)
        self.room.deliver(link, datagram, self.scheduler.now, self.sender)
        self.scheduler.sleep(PACKET_S)


def scanned_uris(count: int) -> tuple[str, ...]:
    """Return the URIs of `count` vehicles that a scan answers: the factory's address, then 01, 02, ..."""
    return (f"{SCANNED}E7",) if count == 1 else tuple(f"{SCANNED}{k + 1:02X}" for k in range(count))
