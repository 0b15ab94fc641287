"""Keep the wall-clock record of a flight: latency of each tick, ticks missed, real-time factor."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass

import numpy as np

RECENT = 100
"""Ticks that `/diagnostics` speaks of: a second of live flight."""


@dataclass(frozen=True, slots=True)
class FlightTiming:
    """Wall-time figures of a flight."""

    ticks: int
    missed_ticks: int
    real_time_factor: float | None
    """Simulated over wall time; None where nothing was simulated."""
    latency_p50_ms: float | None
    """Mocap frame out to its command in, median; None where no command came."""
    latency_p99_ms: float | None


class FlightClock:
    """Note when each tick went out and its command came back, in wall time given by the caller [s]."""

    def __init__(self) -> None:
        self._start = 0.0
        self._out = 0.0
        self._latencies: list[float] = []
        self._missed = 0
        self._ticks = 0

    def start(self, now: float) -> None:
        """Note the start of the flight."""
        self._start = now

    def frame_out(self, now: float) -> None:
        """Note that a tick's frame was published."""
        self._out = now
        self._ticks += 1

    def command_in(self, now: float) -> None:
        """Note that the tick's command came."""
        self._latencies.append(now - self._out)

    def missed(self) -> None:
        """Note that the tick's command did not come."""
        self._missed += 1

    def recent(self) -> Mapping[str, str]:
        """Return the latency of the last ticks in words; nothing before the first command."""
        p50, p99 = _percentiles_ms(self._latencies[-RECENT:])
        if p50 is None:
            return {}
        return {"latency_p50_ms": f"{p50:.3g}", "latency_p99_ms": f"{p99:.3g}"}

    def timing(self, now: float, flown: float) -> FlightTiming:
        """Return the record after `flown` simulated seconds."""
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
    """Return the median and 99th percentile [ms] of latencies [s]; None where there are none."""
    if not latencies:
        return None, None
    p50, p99 = (1e3 * np.percentile(latencies, (50, 99))).tolist()
    return p50, p99


def timing_of(fields: Mapping[str, float | None]) -> FlightTiming:
    """Return the record in the plain fields of `as_fields`."""
    return FlightTiming(
        ticks=int(fields["ticks"] or 0),
        missed_ticks=int(fields["missed_ticks"] or 0),
        real_time_factor=fields["real_time_factor"],
        latency_p50_ms=fields["latency_p50_ms"],
        latency_p99_ms=fields["latency_p99_ms"],
    )


def as_fields(timing: FlightTiming) -> dict[str, int | float | None]:
    """Return the record as plain fields for JSON."""
    return asdict(timing)
