"""Speak Foxglove's WebSocket protocol (foxglove.sdk.v1) as a viewer does, to test what a viewer gets.

RFC 6455 frames over one socket; of the protocol: `advertise`, `subscribe` and message data (opcode 1: one
byte, subscription u32, log time u64, payload; little endian).
"""

import base64
import json
import os
import select
import socket
import struct
from dataclasses import dataclass
from typing import Self

HANDSHAKE = (
    "GET / HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
    "Sec-WebSocket-Key: {key}\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Protocol: foxglove.sdk.v1\r\n\r\n"
)
TEXT, BINARY, CLOSE = 1, 2, 8
"""Opcodes of frames."""
MASKED, LONG, LONGER = 0x80, 126, 127
HEAD = struct.Struct("<BIQ")


@dataclass(frozen=True, slots=True)
class Received:
    """Message of a channel."""

    log_time_ns: int
    payload: bytes


class FoxgloveClient:
    """Connection; a context manager."""

    def __init__(self, port: int, timeout_s: float) -> None:
        """Connect; every wait ends with TimeoutError after `timeout_s` [s]."""
        self._socket = socket.create_connection(("127.0.0.1", port), timeout_s)
        key = base64.b64encode(os.urandom(16)).decode()
        self._socket.sendall(HANDSHAKE.format(key=key).encode())
        self._stream = self._socket.makefile("rb")
        assert b"101" in self._stream.readline()
        while self._stream.readline() != b"\r\n":
            pass

    def __enter__(self) -> Self:
        """Return the connection."""
        return self

    def __exit__(self, *_: object) -> None:
        """Hang up."""
        self._stream.close()
        self._socket.close()

    def subscribe(self, topic: str) -> str:
        """Subscribe to a topic once it is advertised; return the name of its schema."""
        while True:
            kind, data = self._frame()
            output = json.loads(data) if kind == TEXT else {}
            for channel in output.get("channels", []):
                if channel["topic"] == topic:
                    expected = {"op": "subscribe", "subscriptions": [{"id": 7, "channelId": channel["id"]}]}
                    self._send(json.dumps(expected).encode())
                    return str(channel["schemaName"])

    def poll(self, wait_s: float) -> Received | None:
        """Return a message of the subscription if a frame comes within wait_s [s] and is one."""
        if not select.select([self._socket], [], [], wait_s)[0]:
            return None
        kind, data = self._frame()
        if kind != BINARY or data[0] != 1:
            return None
        _, subscription, log_time_ns = HEAD.unpack_from(data)
        assert subscription == 7
        return Received(log_time_ns, data[HEAD.size :])

    def _frame(self) -> tuple[int, bytes]:
        first, length = self._stream.read(2)
        if length == LONG:
            (length,) = struct.unpack(">H", self._stream.read(2))
        elif length == LONGER:
            (length,) = struct.unpack(">Q", self._stream.read(8))
        assert first & 0x0F != CLOSE
        return first & 0x0F, self._stream.read(length)

    def _send(self, data: bytes) -> None:
        mask = os.urandom(4)
        length = struct.pack(">BBH", MASKED | TEXT, MASKED | LONG, len(data))
        self._socket.sendall(length + mask + bytes(byte ^ mask[k % 4] for k, byte in enumerate(data)))
