"""Count what a node lives through, and grade it as REP 107 does: ok, warn, error, stale."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import IntEnum


class Level(IntEnum):
    """Level of a node's health (diagnostic_msgs/DiagnosticStatus)."""

    OK = 0
    WARN = 1
    ERROR = 2
    STALE = 3


@dataclass(slots=True)
class Health:
    """Counters of one node since its start."""

    ticks: int = 0
    """Ticks answered."""
    missed: int = 0
    """Ticks given up because an input did not come."""
    refused: int = 0
    """Messages refused at the boundary."""
    last_refusal: str = ""
    """Why the last one was refused."""
    fallbacks: int = 0
    """Ticks answered in the documented fallback."""
    extra: dict[str, str] = field(default_factory=dict)
    """What else the node has to say."""

    def refuse(self, reason: str) -> None:
        """Count a refused message."""
        self.refused += 1
        self.last_refusal = reason


@dataclass(frozen=True, slots=True)
class HealthReport:
    """Summary of one second of a node."""

    level: Level
    summary: str
    values: Mapping[str, str]


def report(before: Health, now: Health) -> HealthReport:
    """Return the grade of the time between two readings of a node's counters."""
    ticks = now.ticks - before.ticks
    values = {
        "ticks": str(now.ticks),
        "missed": str(now.missed),
        "refused": str(now.refused),
        "last_refusal": now.last_refusal,
        "fallbacks": str(now.fallbacks),
        **now.extra,
    }
    if now.refused > before.refused:
        return HealthReport(Level.ERROR, f"refused: {now.last_refusal}", values)
    if now.fallbacks > before.fallbacks or now.missed > before.missed:
        return HealthReport(Level.WARN, "in fallback or missing ticks", values)
    if ticks == 0:
        return HealthReport(Level.STALE, "no tick", values)
    return HealthReport(Level.OK, f"{ticks} ticks", values)
