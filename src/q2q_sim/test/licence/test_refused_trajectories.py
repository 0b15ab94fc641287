"""The start of a trajectory that a vehicle refuses is a command that it cannot follow."""

import struct

import numpy as np
import pytest

from cflib_fleet import CflibFleet
from q2q_sim.crtp.packets.packet import Packet, Port, datagram_of, packet_of
from q2q_sim.crtp.ports.commander_high_level import COMPRESSED, IN_MEMORY, POLY4D, HighLevel
from q2q_sim.firmware.supervisor.rules import State
from q2q_sim.licence.client_commands.client_command import Asked
from q2q_sim.licence.client_commands.packet_command import client_command
from q2q_sim.licence.crazyflie_py import server_packets

NUMBER = 3


@pytest.fixture
def hovering() -> CflibFleet:
    """Return a vehicle that its high-level commander keeps at 1 m."""
    crazyflies = CflibFleet(np.array([[0.2, 0.0, 1.0, 0.0]]))
    crazyflies.fly(0.1)
    asked(crazyflies, server_packets.vertical(server_packets.TAKE_OFF, 1.0, 1.0, 0))
    crazyflies.fly(0.5)
    return crazyflies


def asked(crazyflies: CflibFleet, packet: Packet) -> Asked:
    """Return what a packet asks of the vehicle, which has answered it."""
    answers = crazyflies.fleet.vehicles[0].handle(datagram_of(packet))
    found = client_command(packet, [packet_of(one) for one in answers], crazyflies.firmware())
    assert found is not None
    return found


def started(crazyflies: CflibFleet, kind: int, pieces: int, timescale: float = 1.0) -> Asked:
    """Return what the start of a trajectory asks that begins the memory, into which nothing was uploaded."""
    definition = struct.pack("<BBBBIB", HighLevel.DEFINE, NUMBER, IN_MEMORY, kind, 0, pieces)
    assert not asked(crazyflies, Packet(Port.HIGH_LEVEL, 0, definition)).impossible
    return asked(crazyflies, server_packets.start(NUMBER, timescale, backwards=False, relative=True, mask=0))


@pytest.mark.parametrize(
    ("pieces", "told"),
    [
        (31, "trajectory 3, with 31 of 31 pieces not uploaded"),  # of 132 bytes: they end at byte 4092
        (32, "trajectory 3, whose 32 pieces end at byte 4224 of a memory of 4096"),
        (0, "trajectory 3, whose 0 pieces end at byte 0 of a memory of 4096"),
    ],
)
def test_a_trajectory_that_ends_beyond_the_memory_is_impossible(
    hovering: CflibFleet, pieces: int, told: str
) -> None:
    start = started(hovering, POLY4D, pieces)
    assert start.impossible == told
    assert bool(start.refused) == (pieces != 31)


def test_a_compressed_trajectory_that_is_stretched_is_impossible_unless_the_vehicle_may_not_fly(
    hovering: CflibFleet,
) -> None:
    told = "trajectory 3, compressed, which leaves the memory or is to be reversed or stretched"
    assert started(hovering, COMPRESSED, 1, 2.0).impossible == told
    hovering.firmware().supervisor.state = State.LOCKED
    grounded = started(hovering, COMPRESSED, 1, 2.0)
    assert (grounded.impossible, grounded.refused) == ("", "the vehicle is not armed")
