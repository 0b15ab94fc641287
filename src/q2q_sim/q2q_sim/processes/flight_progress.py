"""Progress of a flight through nodes, as these report it: ticks, the end of a playback, the summary."""

import reprlib
from collections.abc import Collection, Mapping
from contextlib import suppress

from q2q_model.node.node_names import UNKNOWN_NAME
from q2q_model.signals.stamps import TICK_NS, BadStampError, stamp_from_parts
from q2q_model.signals.topic_names import FLIGHT_SUMMARY
from q2q_sim.simulator.flight_clock import FlightTiming, timing_from_text

STILL_S = 60.0
"""Time without a tick after which a flight has failed [s]."""
SOURCES = ("/simulator", "/bag_play")
"""Nodes that publish ticks."""
SUMMARY = f"/{FLIGHT_SUMMARY}"


class FlightProgress:
    """What the nodes of a flight have reported; the caller gives the wall time [s]."""

    def __init__(self, now: float) -> None:
        self.ticks = 0
        """Ticks flown, as last reported."""
        self.summary: str | None = None
        self.is_played = False
        """Whether the playback is over."""
        self._moved_at, self._moved_to = now, 0

    def start(self, now: float) -> None:
        """Await the first tick from now on."""
        self._moved_at = now

    def take_clock(self, seconds: int, nanoseconds: int) -> None:
        """Take the time of a clock; one of another node, which is no stamp of a tick, changes nothing."""
        with suppress(BadStampError):
            self.ticks = stamp_from_parts(seconds, nanoseconds) // TICK_NS

    def take_diagnostics(self, node: str, values: Mapping[str, str]) -> None:
        """Take the diagnostic values of a node; only the ticks of SOURCES count."""
        reported = values.get("ticks", "")
        if node.endswith(SOURCES) and reported.isdecimal():
            self.ticks = int(reported)

    def check(self, now: float) -> None:
        """Raise TimeoutError if no tick came for STILL_S."""
        if self.ticks != self._moved_to:
            self._moved_at, self._moved_to = now, self.ticks
        if now - self._moved_at > STILL_S:
            raise TimeoutError(f"no tick for {STILL_S:g} s after tick {self.ticks}; see the nodes' logs")


def check_one_writer(writers: Collection[str]) -> None:
    """Raise ValueError if more than one living node writes summaries."""
    found = sorted(name for name in writers if name != UNKNOWN_NAME)
    if len(found) > 1:
        raise ValueError(
            f"another flight was in this ROS domain ({SUMMARY} is written by {', '.join(found)}): "
            "set another ROS_DOMAIN_ID"
        )


def timing_of_summary(summary: str, writers: Collection[str]) -> FlightTiming:
    """Return the timing of a flight from its summary.

    Raises:
        ValueError: the text is no timing; the error names the nodes that write summaries.
    """
    try:
        return timing_from_text(summary)
    except ValueError as misfit:
        named = ", ".join(sorted(writers)) or "a node that has left"
        raise ValueError(
            f"{SUMMARY} of {named} is {reprlib.repr(summary)}: {misfit}: "
            "end other nodes that write it, or give this flight another ROS_DOMAIN_ID"
        ) from misfit
