"""Questions to a vehicle that speaks CRTP, for tests."""

from cflib_fleet import CflibFleet


def ask(crazyflies: CflibFleet, datagram: bytes) -> bytes:
    """Return the answer of a vehicle to a datagram, without its header."""
    (answer,) = crazyflies.fleet.vehicles[0].handle(datagram)
    assert answer[0] & 0xF3 == datagram[0] & 0xF3  # same port and channel
    return answer[1:]
