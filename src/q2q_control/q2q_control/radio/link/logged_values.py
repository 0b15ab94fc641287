"""Last values that a vehicle has logged, and when."""

from dataclasses import dataclass, field
from math import inf, nan

from q2q_control.radio.link.vehicle_link import OnboardPose


@dataclass(slots=True)
class LoggedValues:
    """Last values logged by a vehicle."""

    volt: float = nan
    info: int = 0
    info_at: float = -inf
    """Time of `info` [s]."""
    quality: float = nan
    pose: OnboardPose | None = None
    received: float = -inf
    """Time of the last packet [s]."""
    not_logged: str = ""
    """Why required values are not logged."""
    console: list[str] = field(default_factory=list)
    """Complete console lines."""
    line: str = ""
    """Incomplete console line."""
