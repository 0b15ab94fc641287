"""Port 15: echo and source.

Source: firmware: modules/src/crtpservice.c.

| channel | request | answer |
|---|---|---|
| 0 | any | the same |
| 1 | any | "Bitcraze Crazyflie", filled to 30 bytes with 0 |
| 2 | any | none |
"""

from q2q_sim.crtp.packets.packet import MAX_DATA, Packet

ECHO, SOURCE = 0, 1
GREETING = b"Bitcraze Crazyflie"
ECHO_REQUEST = b"\xfc\x00"
"""Datagram that radios send without a packet of their own; it keeps a vehicle's logs alive."""


def serve(packet: Packet) -> list[Packet]:
    """Answer a packet."""
    if packet.channel == ECHO:
        return [packet]
    return [packet.answer(GREETING.ljust(MAX_DATA, b"\0"))] if packet.channel == SOURCE else []
