"""Line of a benchmark: a figure of q2q with a reference measured in the same run."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Row:
    """Figure of a benchmark."""

    name: str
    """A name that starts with a space belongs to the last one before it that does not."""
    value: float
    unit: str
    reference: str | None = None
    """What it is measured against."""
    ratio: float | None = None
    """Reference over ours in the same run: above 1 we are better."""
    baseline: float | None = None
    """Value of the same row in the checkout of `--baseline`; None if it has no such row."""
