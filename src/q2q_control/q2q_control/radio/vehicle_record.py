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


STOP_AGAIN_S = 2.0
"""Connected time for which an emergency stop is sent again until the vehicle is locked [s]."""
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
    stop_left: float = 0.0
    """Connected time for which that stop is still sent again [s]; 0 once the vehicle was locked."""
    commanded_at: float = -inf
    """Time of the last command since arming [s]."""
    height: float = 0.0
    """Last measured height [m], world."""
    landing_s: float = 0.0
    """Duration of its landing [s]."""
    full_state: FullState | None = None
    """Last full state sent."""

    def stop(self, t: float) -> None:
        """Note an emergency stop at time t [s]."""
        self.stopped_at, self.stop_left = t, STOP_AGAIN_S

    def stop_again(self, *, locked: bool, connected_s: float) -> bool:
        """Return whether to send its emergency stop again, after it was connected for `connected_s` [s]."""
        self.stop_left = 0.0 if locked else max(0.0, self.stop_left - connected_s)
        return self.stop_left > 0.0
