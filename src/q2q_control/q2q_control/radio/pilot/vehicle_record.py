"""Phase of a vehicle flown over the radio, and what it was last sent."""

from dataclasses import dataclass
from enum import Enum
from math import inf

from q2q_control.radio.link.setpoints import FullState


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


CUT_AGAIN_S = 2.0
"""Connected time for which a cut of the motors is sent again until the vehicle is locked [s]."""
AIRBORNE = frozenset({Phase.CLIMBING, Phase.FLYING, Phase.LANDING})
ON_BOARD = {
    Phase.CLIMBING: "its high-level commander keeps hovering",
    Phase.FLYING: "its firmware levels out, then cuts its motors",
    Phase.LANDING: "its high-level commander keeps landing",
}
"""What a vehicle does whose link is lost in a phase."""


@dataclass(slots=True)
class VehicleRecord:
    """Phase of a vehicle, and what it was last sent."""

    phase: Phase = Phase.OFFLINE
    since: float = 0.0
    """Start of the phase [s], also of a landing ordered while offline."""
    lost: Phase | None = None
    """If OFFLINE, its phase in the air: the one lost, or LANDING once it is ordered to land; else None."""
    measured_at: float = -inf
    """Time of the last measured state [s]."""
    low_since: float = inf
    """Start of the low battery [s]."""
    cut_at: float = -inf
    """Time at which its motors were last cut since arming [s]."""
    watched_at: float = inf
    """Time at which it was last watched, connected [s]."""
    cut_left: float = 0.0
    """Connected time for which that cut is still sent again [s]; 0 once the vehicle was locked."""
    commanded_at: float = -inf
    """Time of the last command since arming [s]."""
    height: float = 0.0
    """Last measured height [m], world."""
    landing_s: float = 0.0
    """Duration of its landing [s]."""
    full_state: FullState | None = None
    """Last full state sent."""

    @property
    def air_phase(self) -> Phase:
        """Return its phase, of a vehicle lost in the air the one on board."""
        return self.lost or self.phase

    def enter(self, phase: Phase, t: float) -> None:
        """Enter a phase at time t [s]; a vehicle that is lost and ordered to land stays OFFLINE."""
        if phase is Phase.LANDING and self.lost is not None:
            self.lost, self.since = phase, t
            return
        self.lost = self.phase if phase is Phase.OFFLINE and self.phase in AIRBORNE else None
        self.phase, self.since = phase, t

    def arm(self) -> None:
        """Forget the last flight."""
        self.low_since, self.commanded_at, self.full_state = inf, -inf, None
        self.cut_at, self.cut_left = -inf, 0.0

    def cut(self, t: float) -> None:
        """Note that its motors are cut at time t [s]."""
        self.cut_at, self.cut_left, self.lost = t, CUT_AGAIN_S, None

    def poll_cut(self, t: float, *, locked: bool) -> bool:
        """Return whether to cut its motors again at time t [s], connected; count down the time for that."""
        connected_s = 0.0 if self.phase is Phase.OFFLINE else max(0.0, t - self.watched_at)
        self.watched_at = t
        self.cut_left = 0.0 if locked else max(0.0, self.cut_left - connected_s)
        return self.cut_left > 0.0
