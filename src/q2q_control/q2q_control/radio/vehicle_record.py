"""Phase of a vehicle flown over the radio, and what it was last sent."""

from dataclasses import dataclass
from enum import Enum
from math import inf

from q2q_control.radio.setpoints import FullState


class Phase(Enum):
    """Phase of a vehicle."""

    OFFLINE = "offline"
    READY = "ready"
    ARMING = "arming"
    ARMED = "armed"
    CLIMBING = "climbing"
    """By its onboard commander, which then hovers."""
    FLYING = "flying"
    LANDING = "landing"


AIRBORNE = frozenset({Phase.CLIMBING, Phase.FLYING, Phase.LANDING})


@dataclass(slots=True)
class VehicleRecord:
    """Phase of a vehicle, and what it was last sent."""

    phase: Phase = Phase.OFFLINE
    since: float = 0.0
    """Start of the phase [s]."""
    measured_at: float = -inf
    """Time of the last measured state [s]."""
    low_since: float = inf
    """Start of the low battery [s]."""
    stopped_at: float = -inf
    """Time of its last emergency stop since arming [s]."""
    commanded_at: float = -inf
    """Time of the last command since arming [s]."""
    height: float = 0.0
    """Last measured height [m]."""
    landing_s: float = 0.0
    """Duration of its landing [s]."""
    full_state: FullState | None = None
    """Last full state sent."""
