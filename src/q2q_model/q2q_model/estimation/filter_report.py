"""What the mocap filter found in frames, and counts of what it did with them."""

from dataclasses import dataclass
from typing import NamedTuple

from q2q_model.signals.values import Names


class FrameWarnings(NamedTuple):
    """Vehicles of which a frame was wrong, or said nothing."""

    exchanged: Names = ()
    """They were found under the names of others."""
    frozen: Names = ()
    """Their poses repeat in spite of noise."""
    outside: Names = ()
    """Their positions are further from the origin than any that is accepted."""
    not_unit: Names = ()
    """Their quaternions are not of unit length."""
    upside_down: Names = ()
    """Their quaternions say that they are upside down."""
    missing: Names = ()
    """They have no position."""
    rejected: Names = ()
    """Their positions fail the gates on jumps."""
    low_rate: Names = ()
    """The frame rate is so low that one lost frame loses them."""


@dataclass(frozen=True, slots=True)
class FilterReport:
    """Counts of the filter since its start (resets do not clear them)."""

    frames: int = 0
    """Frames taken."""
    samples: int = 0
    """Finite positions of tracked vehicles."""
    refused: int = 0
    """Samples rejected by a gate."""
    swapped: int = 0
    """Samples assigned to another vehicle than the one they name."""
    restarted: int = 0
    """Tracks restarted: true jumps, and vehicles found again."""
    attitudes_refused: int = 0
    """Quaternions rejected by the gate on turning."""
    not_finite: int = 0
    """Rows of the frame without a position."""
    unknown_names: int = 0
    """Rows of vehicles that are not tracked."""
    repeated_names: int = 0
    """Rows with a name that occurred before in the same frame; the first counts."""
    stale_frames: int = 0
    """Frames older than the last one, too far ahead of it, or without a time."""
    repeated_frames: int = 0
    """Frames with the last one's stamp."""
    clock_resets: int = 0
    """Times that the clock was set back."""
