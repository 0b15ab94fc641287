"""Answer a request: granted, or why not."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Reply:
    """Answer to a request."""

    granted: bool
    reason: str = ""
    """What has happened, or why nothing has."""
