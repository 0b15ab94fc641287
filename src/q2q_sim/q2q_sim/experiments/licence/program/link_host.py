"""Where the links of a program end: at the vehicles of a LicenceRoom, with the program's place that calls."""

import sys
from collections.abc import Callable
from dataclasses import dataclass
from types import FrameType
from typing import NamedTuple

from q2q_sim.experiments.licence.licence_room import PACKET_S, LicenceRoom, OpenLink
from q2q_sim.experiments.licence.program.program_turns import Turns, never


class Sender(NamedTuple):
    """Place in the program that sends a packet."""

    line: int
    closing: bool


@dataclass(frozen=True, slots=True)
class LinkHost:
    """Where the links of a program end."""

    room: LicenceRoom
    turns: Turns
    program: str
    """File of the program, as its frames name it."""
    vehicle_of: Callable[[str], int]
    """Return the vehicle of a URI."""
    scanned: tuple[str, ...]
    """URIs that a scan answers."""

    @property
    def sender(self) -> Sender:
        """Return the line of the program that has called, 0 if none has, and whether it closes a link."""
        frame: FrameType | None = sys._getframe()  # noqa: SLF001
        closing = False
        while frame is not None:
            code = frame.f_code
            if code.co_filename == self.program:
                return Sender(frame.f_lineno, closing)
            closing = closing or code.co_name == "close_link"
            frame = frame.f_back
        return Sender(0, closing)

    def passes(self, link: OpenLink) -> bool:
        """Return whether packets to a vehicle pass now."""
        return self.room.silent_until(link.vehicle, self.turns.now) <= self.turns.now

    def send(self, link: OpenLink, datagram: bytes) -> None:
        """Send a packet to a vehicle; returns after the time that it takes."""
        passes = self.room.silent_until(link.vehicle, self.turns.now)
        if passes == float("inf"):
            return
        if passes > self.turns.now:
            self.turns.wait(never, passes)
        self.room.deliver(link, datagram, self.turns.now, self.sender)
        self.turns.sleep(PACKET_S)
