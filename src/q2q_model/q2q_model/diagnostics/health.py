"""Counters of a node and their REP 107 diagnostic level: ok, warn, error, stale."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import IntEnum

from q2q_model.counted import counted

LONGEST_REASON = 500
"""Longest reason of a refusal that is kept [characters]: some repeat names or keys of what was refused."""


class Level(IntEnum):
    """Diagnostic level of a node (diagnostic_msgs/DiagnosticStatus)."""

    OK = 0
    WARN = 1
    ERROR = 2
    STALE = 3


@dataclass(slots=True)
class Health:
    """Counters of one node since its start."""

    ticks: int = 0
    """Completed ticks."""
    missed: int = 0
    """Ticks dropped because an input was missing."""
    refused: int = 0
    """Rejected input messages."""
    last_refusal: str = ""
    """Reason for the last rejection."""
    fallbacks: int = 0
    """Ticks completed in the documented fallback."""
    fallback: str = ""
    """Which fallback the node is in, where there are several."""
    failure: str = ""
    """Why the node no longer does its work, and what the user has to do."""
    doubts: dict[str, str] = field(default_factory=dict)
    """What makes a tick's inputs or output doubtful now, by what has found it; empty texts are none."""
    awaited: str = ""
    """Why ticks are not completed: inputs that do not come."""
    extra: dict[str, str] = field(default_factory=dict)
    """Further diagnostic values of the node."""

    def refuse(self, reason: str) -> None:
        """Count a rejected message, and keep the beginning of the reason."""
        self.refused += 1
        long = len(reason) > LONGEST_REASON
        self.last_refusal = f"{reason[: LONGEST_REASON - 3]}..." if long else reason


@dataclass(frozen=True, slots=True)
class HealthReport:
    """Diagnostic status of a node over one second."""

    level: Level
    summary: str
    values: Mapping[str, str]
    trouble: bool = False
    """Whether messages are refused or ticks lack an input, which the user must fix."""


def tick_rate(before: Health, now: Health, seconds: float) -> float:
    """Return the rate of completed ticks between two readings, `seconds` apart [Hz]; 0 if that is no time."""
    return (now.ticks - before.ticks) / seconds if seconds > 0.0 else 0.0


def health_report(before: Health, now: Health) -> HealthReport:
    """Return the diagnostic status of the time between two readings of the counters."""
    ticks = now.ticks - before.ticks
    values = {
        "ticks": str(now.ticks),
        "missed": str(now.missed),
        "refused": str(now.refused),
        "last_refusal": now.last_refusal,
        "fallbacks": str(now.fallbacks),
        **now.extra,
    }
    if now.failure:
        return HealthReport(Level.ERROR, now.failure, values)
    if now.refused > before.refused:
        return HealthReport(Level.ERROR, f"refused: {now.last_refusal}", values, trouble=True)
    if now.missed > before.missed and not ticks and now.awaited:
        return HealthReport(Level.WARN, f"no tick: {now.awaited}", values, trouble=True)
    if warnings := _warnings(before, now):
        return HealthReport(Level.WARN, "; ".join(warnings), values)
    if ticks == 0:
        return HealthReport(Level.STALE, f"no tick: {now.awaited}" if now.awaited else "no tick", values)
    return HealthReport(Level.OK, counted(ticks, "tick"), values)


def _warnings(before: Health, now: Health) -> list[str]:
    """Return what was amiss between two readings, though ticks were completed."""
    found = []
    if now.fallbacks > before.fallbacks:
        found.append(f"in fallback{': ' if now.fallback else ''}{now.fallback}")
    if now.missed > before.missed:
        found.append("missing ticks")
    return found + [doubt for doubt in now.doubts.values() if doubt]
