"""Wait before a playback for the nodes that read it: a message sent to a reader not yet matched is lost."""

from collections.abc import Mapping

SETTLED_S = 0.5
"""Time without a new match after which the subscribers of a topic are taken to be matched [s]."""
LONGEST_S = 4.0
"""Longest wait [s]: Fast DDS announces a process again after 3 s if its first announcements were lost."""


class SubscriberWait:
    """Wait until each topic has a subscriber, and its matches stand still."""

    def __init__(self, now: float) -> None:
        """Take the wall time of the first look [s]."""
        self._began = self._changed = now
        self._matches: dict[str, int] = {}

    def update(self, now: float, matches: Mapping[str, int]) -> bool:
        """Return whether to begin at wall time now [s], from the matched subscribers of each topic."""
        if matches != self._matches:
            self._matches, self._changed = dict(matches), now
        return now - self._began >= LONGEST_S or (all(matches.values()) and now - self._changed >= SETTLED_S)

    def note(self) -> str:
        """Return the line to log at the beginning."""
        silent = [topic for topic, count in self._matches.items() if not count]
        return (
            f"starts: after {LONGEST_S:g} s no node is connected on {', '.join(silent)}"
            if silent
            else "begins"
        )
