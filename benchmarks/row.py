"""Line of a benchmark: a figure of q2q beside a reference measured in the same run."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Row:
    """Figure of a benchmark."""

    name: str
    value: float
    unit: str
    reference: str | None = None
    """What it is measured against."""
    ratio: float | None = None
    """Reference over ours in the same run: above 1 we are better."""
