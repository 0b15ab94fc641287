"""Wall-clock timing of a flight: latency of each tick, missed ticks, real-time factor."""

from array import array
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass

import numpy as np

RECENT = 100
"""Ticks that `/diagnostics` reports on: one second of live flight."""


@dataclass(frozen=True, slots=True)
class FlightTiming:
    """Wall-time figures of a flight."""

    ticks: int
    missed_ticks: int
    real_time_factor: float | None
    """Simulated over wall time; None if nothing was simulated."""
    latency_p50_ms: float | None
    """From sending a mocap frame to receiving its command, median; None without commands."""
    latency_p99_ms: float | None


class FlightClock:
    """Timer of ticks and their commands; the caller gives the wall time [s]."""

    def __init__(self) -> None:
        self._start = 0.0
        self._out = 0.0
        self._latencies = array("d")  # a list would hold 32 bytes a tick, 11 MB an hour
        self._missed = 0
        self._ticks = 0

    def start(self, now: float) -> None:
        """Record the start of the flight."""
        self._start = now

    def frame_out(self, now: float) -> None:
        """Record that the frame of a tick was published."""
        self._out = now
        self._ticks += 1

    def command_in(self, now: float) -> None:
        """Record that the command of the tick arrived."""
        self._latencies.append(now - self._out)

    def missed(self) -> None:
        """Record that the command of the tick did not arrive."""
        self._missed += 1

    def recent(self) -> Mapping[str, str]:
        """Return the latency of the last ticks as text; empty before the first command."""
        p50, p99 = _percentiles_ms(self._latencies[-RECENT:])
        if p50 is None:
            return {}
        return {"latency_p50_ms": f"{p50:.3g}", "latency_p99_ms": f"{p99:.3g}"}

    def timing(self, now: float, flown: float) -> FlightTiming:
        """Return the timing after `flown` simulated seconds."""
        wall = now - self._start
        p50, p99 = _percentiles_ms(self._latencies)
        return FlightTiming(
            ticks=self._ticks,
            missed_ticks=self._missed,
            real_time_factor=flown / wall if wall > 0.0 else None,
            latency_p50_ms=p50,
            latency_p99_ms=p99,
        )


def _percentiles_ms(latencies: Sequence[float]) -> tuple[float, float] | tuple[None, None]:
    """Return the median and 99th percentile [ms] of latencies [s]; None if there are none."""
    if not latencies:
        return None, None
    p50, p99 = (1e3 * np.percentile(latencies, (50, 99))).tolist()
    return p50, p99


def timing_of(fields: Mapping[str, float | None]) -> FlightTiming:
    """Return the timing that `as_fields` wrote."""
    return FlightTiming(
        ticks=int(fields["ticks"] or 0),
        missed_ticks=int(fields["missed_ticks"] or 0),
        real_time_factor=fields["real_time_factor"],
        latency_p50_ms=fields["latency_p50_ms"],
        latency_p99_ms=fields["latency_p99_ms"],
    )


def as_fields(timing: FlightTiming) -> dict[str, int | float | None]:
    """Return the timing as plain fields for JSON."""
    return asdict(timing)
