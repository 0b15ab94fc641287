"""Link driver for cflib whose vehicles are those of a LicenceRoom, at any URI.

A program opens vehicles by the URIs that it has: the n-th of the URIs that are known is the n-th vehicle.
Needs the interface of cflib's drivers (cflib: crtp/crtpdriver.py). One packet takes PACKET_S, and vehicles
do not share radios.
"""

import threading
import time
from collections.abc import Callable

import cflib.crtp
from cflib.crtp.crtpstack import CRTPPacket
from cflib.crtp.exceptions import WrongUriType

from q2q_sim.licence.program_process.link_host import POLL_S, LinkHost
from q2q_sim.licence.room.licence_room import OpenLink

SCHEMES = ("radio", "usb", "udp", "tcp", "serial")
DRIVERS = ("UsbDriver", "SerialDriver", "UdpDriver", "PrrtDriver", "TcpDriver")
"""Drivers of cflib besides that of the radio."""

Report = Callable[[str], None]


class EmulatedDriver:
    """Driver of one link, as cflib asks for it."""

    host: LinkHost

    def __init__(self) -> None:
        self.needs_resending = False
        self.uri = ""
        self._link: OpenLink | None = None

    def connect(self, uri: str, _: object, link_error_callback: Report | None) -> None:
        """Open the link to the vehicle at a URI."""
        if uri.partition("://")[0] not in SCHEMES:
            raise WrongUriType(f"not the URI of a vehicle: {uri}")
        self.uri = uri
        self.host.scheduler.resume()
        link = self._link = OpenLink(self.host.vehicle_of(uri))
        self.host.room.opened.append(link.vehicle)
        self.host.room.keep_alive(link)
        report: Report = link_error_callback or (lambda _: None)
        threading.Thread(target=self._poll, args=(link, report), daemon=True).start()

    def send_packet(self, pk: CRTPPacket) -> None:
        """Send a packet."""
        if self._link is not None:
            self.host.send(self._link, bytes([pk.header]) + bytes(pk.data))

    def receive_packet(self, wait: float = 0) -> CRTPPacket | None:
        """Return the next packet of the vehicle, after at most `wait` [s]; below 0 without limit."""
        link = self._link
        if link is None:
            time.sleep(max(wait, POLL_S))
            return None
        if not link.inbox and wait != 0:
            until = float("inf") if wait < 0 else self.host.scheduler.now + wait
            self.host.scheduler.wait(lambda: bool(link.inbox), until)
        if not link.inbox:
            return None
        datagram = link.inbox.popleft()
        return CRTPPacket(datagram[0], datagram[1:])

    def close(self) -> None:
        """Close the link."""
        self._link = None

    def get_status(self) -> str:
        """Return a description of the radio."""
        return "emulated vehicles"

    def get_name(self) -> str:
        """Return the name of the driver; of one named "radio", PowerSwitch would look for the real radio."""
        return "emulated"

    def scan_interface(self, address: int | None = None) -> list[list[str]]:
        """Return the URIs of the vehicles in reach, all or that of an address."""
        ends = "" if address is None else f"{address:010X}"
        return [[uri, ""] for uri in self.host.scanned if uri.endswith(ends)]

    def _poll(self, link: OpenLink, report: Report) -> None:
        while self._link is link:
            if self.host.room.is_noticed(link.vehicle, self.host.scheduler.now):
                report("Too many packets lost")
                return
            if self.host.passes(link):
                self.host.room.keep_alive(link)
            time.sleep(POLL_S)


class AbsentDriver:
    """Driver of an interface without vehicles."""

    def connect(self, uri: str, *_: object) -> None:
        """Refuse every URI."""
        raise WrongUriType(f"no vehicle at {uri}")

    def scan_interface(self, _: int | None = None) -> list[list[str]]:
        """Return nothing."""
        return []

    def get_name(self) -> str:
        """Return the name of the driver."""
        return "absent"

    def get_status(self) -> str:
        """Return that there is nothing."""
        return "no interface"


def use_emulated_links(host: LinkHost) -> None:
    """Make every driver that cflib finds in this process end at the vehicles of a host."""
    EmulatedDriver.host = host
    setattr(cflib.crtp, "RadioDriver", EmulatedDriver)  # noqa: B010
    for name in DRIVERS:
        setattr(cflib.crtp, name, AbsentDriver)
