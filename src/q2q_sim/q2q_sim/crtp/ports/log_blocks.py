"""Port 5: creation, start, stop and deletion of log blocks, and their data when due.

Source: firmware: modules/src/log.c. One LogBlocks for each client, so that a second client's reset does not
end the first one's logs. Answers on channel 1 are command, block, error.

| command | fields after it | error |
|---|---|---|
| 6 create | block, then type byte and variable uint16, repeated | EEXIST, ENOMEM, as append |
| 7 append | the same | ENOENT, E2BIG (26 bytes per block), ENOMEM (128 variables) |
| 2 delete, 4 stop | block | ENOENT |
| 3 start | block, period [10 ms] | ENOENT |
| 8 start | block, period uint16 [ms] | ENOENT |
| 5 reset | | |

A block is sent at whole multiples of its period after its start, at the room's ticks (10 ms): block, then 24
bits of milliseconds, then its values. A start with period 0 sends it once, at the next tick; a period that
runs goes on.
"""

import struct
from dataclasses import dataclass, field

from q2q_sim.crtp.packets.fields import byte, read_fields
from q2q_sim.crtp.packets.packet import Packet, Port
from q2q_sim.crtp.tables.log_toc import LOG_MAX_BLOCKS, LOG_MAX_OPS, LOG_TOC, VARIABLES, Variable
from q2q_sim.crtp.tables.number_types import BY_LOG_NUMBER, NumberType
from q2q_sim.firmware.firmware import TICK_MS, Firmware

TOC, CONTROL, DATA = 0, 1, 2
DELETE, START, STOP, RESET, CREATE, APPEND, START_MS = 2, 3, 4, 5, 6, 7, 8
ENOENT, E2BIG, ENOEXEC, ENOMEM, EEXIST = 2, 7, 8, 12, 17
MAX_VALUES = 26
"""Bytes of values in a packet."""
_OPERATION, _PERIOD = struct.Struct("<BH"), struct.Struct("<H")
_TYPE_MASK = 0x0F


@dataclass(slots=True)
class _Block:
    """One block."""

    variables: list[tuple[Variable, NumberType]] = field(default_factory=list)
    period_ms: int = 0
    """0 while stopped."""
    next_ms: int = 0
    once: bool = False
    """Started with period 0 since the last tick."""

    @property
    def size(self) -> int:
        return sum(kind.layout.size for _, kind in self.variables)

    def start(self, period_ms: int, now_ms: int) -> None:
        """Send from now on at a period [ms], or once if it is 0."""
        if period_ms == 0:
            self.once = True
            return
        self.period_ms = max(period_ms, TICK_MS)
        self.next_ms = now_ms + self.period_ms

    def packets_due(self, now_ms: int) -> int:
        """Return how many packets are due now [ms]; they are then sent."""
        count, self.once = int(self.once), False
        if self.period_ms == 0 or now_ms < self.next_ms:
            return count
        self.next_ms += self.period_ms
        if self.next_ms <= now_ms:  # time has jumped ahead: no burst
            self.next_ms = now_ms + self.period_ms
        return count + 1


class LogBlocks:
    """Log blocks of one client."""

    def __init__(self) -> None:
        self._blocks: dict[int, _Block] = {}

    def serve(self, packet: Packet, now_ms: int) -> list[Packet]:
        """Return the answers to a packet received at now_ms [ms]."""
        if packet.channel == TOC:
            listed = LOG_TOC.answer(packet.data)
            return [] if listed is None else [packet.answer(listed)]
        if packet.channel != CONTROL:
            return []
        command = byte(packet.data, 0)
        if command == RESET:
            self._blocks.clear()
            return [packet.answer(bytes([RESET, 0, 0]))]
        block = byte(packet.data, 1)
        return [packet.answer(bytes([command, block, self._control(packet.data, now_ms)]))]

    def due(self, firmware: Firmware) -> list[Packet]:
        """Return the packets of blocks that are due at the firmware's time."""
        sent = []
        for number, block in self._blocks.items():
            sent += [_data(number, block, firmware) for _ in range(block.packets_due(firmware.now_ms))]
        return sent

    def _control(self, data: bytes, now_ms: int) -> int:
        command, number = data[0], data[1]
        if command == CREATE:
            return self._create(number, data[2:])
        block = self._blocks.get(number)
        if command not in {DELETE, START, STOP, APPEND, START_MS}:
            return ENOEXEC
        if block is None:
            return ENOENT
        if command == APPEND:
            return self._append(block, data[2:])
        if command == DELETE:
            del self._blocks[number]
        elif command == STOP:
            block.period_ms = 0
        else:
            block.start(_tens(data) if command == START else _milliseconds(data), now_ms)
        return 0

    def _create(self, number: int, operations: bytes) -> int:
        if number in self._blocks:
            return EEXIST
        if len(self._blocks) >= LOG_MAX_BLOCKS:
            return ENOMEM
        self._blocks[number] = _Block()
        return self._append(self._blocks[number], operations)

    def _append(self, block: _Block, operations: bytes) -> int:
        for at in range(0, len(operations) - _OPERATION.size + 1, _OPERATION.size):
            code, number = (int(part) for part in read_fields(_OPERATION, operations, at))
            kind = BY_LOG_NUMBER.get(code & _TYPE_MASK)
            if kind is None or number >= len(VARIABLES):
                return ENOENT
            if block.size + kind.layout.size > MAX_VALUES:
                return E2BIG
            if sum(len(one.variables) for one in self._blocks.values()) >= LOG_MAX_OPS:
                return ENOMEM
            block.variables.append((VARIABLES[number], kind))
        return 0


def _tens(data: bytes) -> int:
    return 10 * byte(data, 2)


def _milliseconds(data: bytes) -> int:
    return int(read_fields(_PERIOD, data, 2)[0])


def _data(number: int, block: _Block, firmware: Firmware) -> Packet:
    stamp = (firmware.now_ms & 0xFFFFFF).to_bytes(3, "little")
    values = b"".join(kind.packed(one.read(firmware)) for one, kind in block.variables)
    return Packet(Port.LOG, DATA, bytes([number]) + stamp + values)
