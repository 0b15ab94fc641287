"""One-line verdict on a flight: ok, or its first failures with their times and how many more there are."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from q2q_model.counted import first_of

MOST_SHOWN = 6
"""Failures, or quantities that were not judged, that a line shows."""


@dataclass(frozen=True, slots=True)
class Finding:
    """One failure in a flight."""

    t: float
    """Stamp [s]."""
    words: str
    """With the time since the first tick [s]."""


@dataclass(frozen=True, slots=True)
class FlightVerdict:
    """Outcome of a flight: failures in order of time, and what could not be judged."""

    duration: float
    """[s]"""
    findings: tuple[Finding, ...] = ()
    unjudged: tuple[str, ...] = ()
    """Quantities missing from the recording."""
    is_part: bool = False
    """Whether a part of a flight was judged, which says nothing of its end."""

    @property
    def ok(self) -> bool:
        """Return whether nothing went wrong."""
        return not self.findings

    @property
    def full_text(self) -> str:
        """Return all that was found, in one line."""
        return "; ".join(self._parts())

    def __str__(self) -> str:
        """Return what was found first, and how much more there is, in one line."""
        kept = MOST_SHOWN + self.ok  # "ok" comes before what was not judged
        return "; ".join(first_of(self._parts(), kept))

    def _parts(self) -> list[str]:
        if self.findings:
            return [one.words for one in self.findings]
        how = "judged, a part of the flight" if self.is_part else "flown to the end"
        known = f"ok: {self.duration:.1f} s {how}"
        return [known, *(f"not judged: {one}" for one in self.unjudged)]


def with_finding(verdict: FlightVerdict, finding: Finding) -> FlightVerdict:
    """Return a verdict with a further failure."""
    found = sorted((*verdict.findings, finding), key=lambda one: one.t)
    return replace(verdict, findings=tuple(found))


def verdict_line(flights: Sequence[tuple[str, FlightVerdict]]) -> str:
    """Return the verdicts on named flights in one line; without the name for a single flight."""
    if len(flights) == 1:
        return f"verdict: {flights[0][1]}"
    return "verdict: " + " | ".join(f"{name}: {verdict}" for name, verdict in flights)
