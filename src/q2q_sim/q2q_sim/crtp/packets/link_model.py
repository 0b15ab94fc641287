"""Delay, lose and queue packets as radios do, each shared by several vehicles.

A radio sends one packet at a time, in both directions: a packet offered at t goes on the air when the radio
is free, takes 1 / rate, and arrives `latency` after that. One that would wait for longer than `patience` is
dropped, whatever it is.

    air(t) = max(free, t),  free' = air(t) + 1 / rate,  arrival = free' + latency

Packets that answer each other (tables, parameters, memory, commands of the high-level commander, ...) are
carried by safe links, which send them again until they arrive: a loss costs them one more turn of
1 / rate + latency. Streams (setpoints, positions, log data) are lost for good: the next one follows anyway.

| symbol | name | meaning [unit] |
|---|---|---|
| latency | latency | [s], each way |
| | loss | share of transmissions lost [-] |
| rate | rate | packets a second of one radio [1/s]; 0 is no limit |
| | patience | [s] |
| | per_radio | vehicles that share a radio |
"""

import heapq
from dataclasses import dataclass
from itertools import count
from typing import Generic, TypeVar

import numpy as np

from q2q_model.tunable import check_bounds, tunable
from q2q_sim.crtp.packets.packet import Port
from q2q_sim.plant.random_streams import stream

T = TypeVar("T")

STREAMED = frozenset((Port.SETPOINT, Port.GENERIC, Port.LOCALIZATION))
"""Ports whose packets are not sent again."""
LOG_DATA = 2
"""Channel of port 5 whose packets are not sent again."""
TRIES = 20
"""A safe link gives a packet up after so many losses."""


@dataclass(frozen=True, slots=True)
class LinkParams:
    """Hold how well packets arrive; the defaults are transparent."""

    latency: float = tunable(0.0, "packet sent to packet received, each way", unit="s", low=0.0, high=0.5)
    loss: float = tunable(0.0, "share of transmissions lost", low=0.0, high=0.9)
    rate: float = tunable(0.0, "packets of one radio, both ways; 0 is no limit", unit="Hz", low=0.0, high=1e5)
    patience: float = tunable(0.1, "longest wait for the radio; then dropped", unit="s", low=0.0, high=10.0)
    per_radio: int = tunable(15, "vehicles that share one radio", low=1, high=1000)

    def __post_init__(self) -> None:
        """Check the bounds."""
        check_bounds(self)


class Radios:
    """Hold when each radio is free."""

    def __init__(self, params: LinkParams, vehicles: int, seed: int) -> None:
        self._params = params
        self._free = np.zeros(-(-vehicles // params.per_radio))
        self._losses = stream(seed, "crtp loss")

    def arrival(self, vehicle: int, datagram: bytes, t: float) -> float | None:
        """Return when a datagram of a vehicle, offered at t [s], arrives [s]; None where it does not."""
        radio = vehicle // self._params.per_radio
        losses = self._count_losses(streamed=is_stream(datagram))
        if losses is None:
            return None
        turn = 1.0 / self._params.rate if self._params.rate > 0.0 else 0.0
        begin = max(float(self._free[radio]), t)
        if begin - t > self._params.patience:
            return None
        self._free[radio] = begin + turn * (1 + losses)
        return begin + (turn + self._params.latency) * (1 + losses)

    def _count_losses(self, *, streamed: bool) -> int | None:
        """Return how often a packet is lost before it arrives; None where it never does."""
        if self._params.loss == 0.0:
            return 0
        lost = self._losses.random(1 if streamed else TRIES) < self._params.loss
        return None if lost.all() else int(np.argmin(lost))


class DelayLine(Generic[T]):
    """Hold what is under way, in the order of arrival; what arrives together keeps its order."""

    def __init__(self) -> None:
        self._heap: list[tuple[float, int, T]] = []
        self._serial = count()

    def push(self, arrival: float, item: T) -> None:
        """Put an item under way that arrives at `arrival` [s]."""
        heapq.heappush(self._heap, (arrival, next(self._serial), item))

    def due(self, t: float) -> list[T]:
        """Return, and forget, what has arrived by t [s]."""
        arrived = []
        while self._heap and self._heap[0][0] <= t:
            arrived.append(heapq.heappop(self._heap)[2])
        return arrived

    @property
    def next_arrival(self) -> float | None:
        """Return when the next item arrives [s]."""
        return self._heap[0][0] if self._heap else None


def is_stream(datagram: bytes) -> bool:
    """Return whether a datagram belongs to a stream."""
    port = datagram[0] >> 4
    return port in STREAMED or (port == Port.LOG and datagram[0] & 0x03 == LOG_DATA)
