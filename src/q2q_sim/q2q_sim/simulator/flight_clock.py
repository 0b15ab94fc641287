"""Wall-clock timing of a flight: latency of each tick, missed ticks, real-time factor."""

import json
from array import array
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass

import numpy as np

from q2q_model.documents.plain_values import from_plain

RECENT = 100
"""Ticks that `/diagnostics` reports on: one second of live flight."""
AWAITED = 1000
"""Frames whose commands are awaited: ten seconds of live flight."""


@dataclass(frozen=True, slots=True)
class FlightTiming:
    """Wall-time figures of a flight."""

    ticks: int
    missed_ticks: int
    """Ticks whose own command did not arrive before the next frame."""
    real_time_factor: float | None
    """Simulated over wall time; None if nothing was simulated."""
    latency_p50_ms: float | None
    """From sending a mocap frame to receiving its command, median; None without commands."""
    latency_p99_ms: float | None


class FlightClock:
    """Timer of ticks and their commands; the caller gives the wall time [s]."""

    def __init__(self) -> None:
        self._start = 0.0
        self._sent: dict[int, float] = {}
        """Stamp [ns] of a frame without command -> when it was published [s]."""
        self._latencies = array("d")  # a list would hold 32 bytes per tick, 11 MB per hour
        self._missed = 0
        self._ticks = 0

    def start(self, now: float) -> None:
        """Record the start of the flight."""
        self._start = now

    def frame_out(self, stamp_ns: int, now: float) -> None:
        """Record that a tick's frame was published; one that is published again counts from the first."""
        self._sent.setdefault(stamp_ns, now)
        if len(self._sent) > AWAITED:
            del self._sent[next(iter(self._sent))]
        self._ticks += 1

    def command_in(self, stamp_ns: int, now: float) -> None:
        """Record that the command of a frame arrived, in its tick or later."""
        sent = self._sent.pop(stamp_ns, None)
        if sent is not None:
            self._latencies.append(now - sent)

    def missed(self) -> None:
        """Record that the command of a tick did not arrive in it."""
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


def timing_from_text(text: str) -> FlightTiming:
    """Return the timing that `timing_as_text` wrote; raise ValueError for any other text."""
    try:
        plain = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise ValueError("not JSON") from error
    return from_plain(FlightTiming, plain, "")


def timing_as_text(timing: FlightTiming) -> str:
    """Return the timing as JSON."""
    return json.dumps(asdict(timing))
