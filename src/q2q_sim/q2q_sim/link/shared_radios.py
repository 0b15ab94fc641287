"""Latency, loss and queueing of packets on radios that are each shared by several vehicles.

A radio sends one packet at a time, in both directions: a packet offered at t is sent when the radio is free,
takes 1 / rate, and arrives `latency` after that. A packet that would wait longer than `patience` is dropped.

    air(t) = max(free, t),  free' = air(t) + 1 / rate,  arrival = free' + latency

Requests and answers (tables, parameters, memory, commands of the high-level commander, ...) use safe links,
which retransmit until they arrive: a loss costs another 1 / rate + latency. Streams (setpoints, positions,
log data) are not retransmitted.

| symbol | name | meaning [unit] |
|---|---|---|
| latency | latency | [s], each way |
| | loss | share of transmissions lost [-] |
| rate | rate | packets per second of one radio [1/s]; 0 is no limit |
| | patience | [s] |
| | per_radio | vehicles that share a radio |
"""

import heapq
from dataclasses import dataclass
from itertools import count
from typing import Generic, TypeVar

import numpy as np

from q2q_model.tunable import check_bounds, tunable
from q2q_sim.random_streams import stream

T = TypeVar("T")

TRIES = 20
"""Losses after which a safe link drops a packet."""


@dataclass(frozen=True, slots=True)
class SharedRadioParams:
    """Quality of the link; the defaults are transparent."""

    latency: float = tunable(0.0, "delay from sending a packet to receiving it", unit="s", low=0.0, high=0.5)
    loss: float = tunable(0.0, "fraction of packet transmissions that are lost", low=0.0, high=0.9)
    rate: float = tunable(
        0.0,
        "largest packet rate of a radio, both directions together; 0: no limit",
        unit="Hz",
        low=0.0,
        high=1e5,
    )
    patience: float = tunable(
        0.1, "time that a packet waits for the radio before it is dropped", unit="s", low=0.0, high=10.0
    )
    per_radio: int = tunable(15, "number of vehicles that share a radio", low=1, high=1000)

    def __post_init__(self) -> None:
        """Check the bounds."""
        check_bounds(self)


class SharedRadios:
    """Radios with the times from which they are free."""

    def __init__(self, params: SharedRadioParams, vehicles: int, seed: int) -> None:
        self._params = params
        self._free = np.zeros(-(-vehicles // params.per_radio))
        self._losses = stream(seed, "crtp loss")

    def arrival(self, vehicle: int, t: float, *, streamed: bool) -> float | None:
        """Return the arrival time of a vehicle's packet offered at t [s]; None if it is lost."""
        radio = vehicle // self._params.per_radio
        losses = self._count_losses(streamed=streamed)
        if losses is None:
            return None
        turn = 1.0 / self._params.rate if self._params.rate > 0.0 else 0.0
        begin = max(float(self._free[radio]), t)
        if begin - t > self._params.patience:
            return None
        self._free[radio] = begin + turn * (1 + losses)
        return begin + (turn + self._params.latency) * (1 + losses)

    def _count_losses(self, *, streamed: bool) -> int | None:
        """Return how often a packet is lost before it arrives; None if it never arrives."""
        if self._params.loss == 0.0:
            return 0
        lost = self._losses.random(1 if streamed else TRIES) < self._params.loss
        return None if lost.all() else int(np.argmin(lost))


class DelayLine(Generic[T]):
    """Items in transit in the order of arrival, first in first out for equal times."""

    def __init__(self) -> None:
        self._heap: list[tuple[float, int, T]] = []
        self._serial = count()

    def push(self, arrival: float, item: T) -> None:
        """Add an item that arrives at `arrival` [s]."""
        heapq.heappush(self._heap, (arrival, next(self._serial), item))

    def due(self, t: float) -> list[T]:
        """Remove and return the items that have arrived by t [s]."""
        arrived = []
        while self._heap and self._heap[0][0] <= t:
            arrived.append(heapq.heappop(self._heap)[2])
        return arrived

    @property
    def next_arrival(self) -> float | None:
        """Return the next arrival time [s]."""
        return self._heap[0][0] if self._heap else None
