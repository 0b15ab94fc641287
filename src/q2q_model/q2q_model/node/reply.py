"""Reply to a service request."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Reply:
    """Reply to a request."""

    granted: bool
    reason: str = ""
    """Result, or reason for the refusal."""
