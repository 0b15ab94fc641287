"""Time of a room, for cflib's scripts: it passes, as fast as it can, while every script of the flight waits.

A tick passes only after the endpoint has taken every packet that scripts have sent. So a script's commands
come at the same ticks on any machine, though packets go over UDP and scripts have threads of their own.
"""

import os
import queue
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import monotonic

import pytest
from cflib.crtp.crtpstack import CRTPPacket
from cflib.crtp.udpdriver import UdpDriver

from cflib_fleet import CflibFleet
from q2q_sim.crtp.ports.link_service import ECHO_REQUEST
from q2q_sim.crtp.udp_endpoint import CrtpEndpoint

TICKS_PER_S = 100
LOOK_S = 0.02
"""How often a thread that waits looks whether the others have ended [s]."""
TAKEN_S = 60.0
"""Packets that the endpoint has not taken by then are lost, which loopback does not do [s]."""


class RoomTime:
    """Clock of one room, in place of cflib's `time`."""

    def __init__(self, crazyflies: CflibFleet, endpoint: CrtpEndpoint) -> None:
        self._crazyflies, self._endpoint = crazyflies, endpoint
        self._change = threading.Condition()
        self._waits: dict[threading.Thread, Callable[[], bool]] = {}
        self._scripts: set[threading.Thread] = {threading.current_thread()}
        self._expected = 1
        self._ticks = 0
        self.sent = 0
        """Packets of all clients."""

    def time(self) -> float:
        """Return the room's time [s]."""
        return self._ticks / TICKS_PER_S

    def sleep(self, seconds: float) -> None:
        """Let the room's time pass."""
        end = self._ticks + round(TICKS_PER_S * seconds)
        self.wait(lambda: self._ticks >= end)

    def wait(self, due: Callable[[], bool]) -> None:
        """Let the room's time pass until `due`."""
        me = threading.current_thread()
        with self._change:
            self._scripts.add(me)
            self._waits[me] = due
            while not due():
                if self._all_wait():
                    self._tick()
                    self._change.notify_all()
                else:
                    self._change.wait(LOOK_S)
            del self._waits[me]

    @contextmanager
    def parallel(self, count: int) -> Iterator[None]:
        """Wait for `count` scripts in threads of their own instead of for the one that starts them."""
        before, self._scripts, self._expected = self._scripts, set(), count
        yield
        self._scripts, self._expected = before, 1

    def expect_one_more(self) -> None:
        """Wait for the thread of a script that is about to start."""
        self._expected += 1

    def _all_wait(self) -> bool:
        alive = [one for one in self._scripts if one.is_alive()]
        begun = len(self._scripts) >= self._expected
        return begun and all(one in self._waits and not self._waits[one]() for one in alive)

    def _tick(self) -> None:
        give_up = monotonic() + TAKEN_S
        while self._endpoint.traffic.received < self.sent:
            assert monotonic() < give_up, f"{self.sent} packets sent, {self._endpoint.traffic} passed"
            os.sched_yield()
        for vehicle in self._crazyflies.fleet.vehicles:
            for client in vehicle.clients:  # as a radio polls, so that nobody is taken for silent
                vehicle.handle(ECHO_REQUEST, client)
        self._endpoint.fly(self._crazyflies.drive)
        self._ticks += 1


class RoomQueue:
    """Queue whose reader waits in the room's time."""

    def __init__(self, clock: RoomTime) -> None:
        self._clock = clock
        self._items: queue.SimpleQueue[object] = queue.SimpleQueue()

    def put(self, item: object) -> None:
        """Add an item."""
        self._items.put(item)

    def empty(self) -> bool:
        """Return whether there is no item."""
        return self._items.empty()

    def get(self, block: bool = True, timeout: float | None = None) -> object:
        """Return the first item; raise queue.Empty where none has come in time."""
        end = float("inf") if timeout is None else self._clock.time() + timeout - 1e-9
        if block:
            self._clock.wait(lambda: not self.empty() or self._clock.time() >= end)
        return self._items.get_nowait()


def in_room_time(clock: RoomTime, patch: pytest.MonkeyPatch) -> None:
    """Let cflib live in a room's time, and count what it sends."""
    send = UdpDriver.send_packet

    def counted(driver: UdpDriver, packet: CRTPPacket) -> None:
        opened = driver.socket
        send(driver, packet)
        clock.sent += opened is not None and driver.socket is opened  # not of a link that closes meanwhile

    def queue_of_a_thread() -> RoomQueue:
        clock.expect_one_more()
        return RoomQueue(clock)

    patch.setattr(UdpDriver, "send_packet", counted)
    for module in ("positioning.motion_commander", "utils.reset_estimator", "crazyflie.swarm"):
        patch.setattr(f"cflib.{module}.time", clock)
    patch.setattr("cflib.positioning.motion_commander.Queue", queue_of_a_thread)
    patch.setattr("cflib.crazyflie.syncLogger.Queue", lambda: RoomQueue(clock))
