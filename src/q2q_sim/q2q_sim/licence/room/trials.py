"""Trials of a licence: flights of a program without faults, then with one fault each.

What each asks of the program:

| trial | fault | asked |
|---|---|---|
| nominal | none | everything |
| radio gap | no packet passes for 0.4 s, then the waiting ones do | everything |
| radio lost | the link is lost for good; cflib learns of it after 1 s | the other vehicles: everything |
| swapped markers | motion capture exchanges two vehicles for 50 ms | everything |
| stale poses | motion capture repeats its last poses for 0.15 s | everything |
| low battery | one cell is at 2 %, and thrust falls by 8 % in 5 s | everything |
| will not arm | one vehicle does not arm | the other vehicles: everything |
| downwash | a vehicle is pushed down as by one above it, 1.5 m/s^2 for 0.5 s | everything |

After a fault a program may refuse to fly, and end with an error while no other vehicle is in the air. The
sizes are such that the firmware holds a hovering vehicle through each of them.
"""

from dataclasses import dataclass
from enum import StrEnum

from q2q_model.signals.values import Names
from q2q_sim.faults.faults import Fault

GAP_S = 0.4
"""Below the firmware's watchdog of 0.5 s."""
SWAP_S, STALE_S = 0.05, 0.15
CHARGE = 0.02
"""Of a low battery [-]."""
SAG, SAG_S = 0.08, 5.0
"""Thrust lost [-], and the time in which it falls [s]."""
PUSH, PUSH_S = 1.5, 0.5
"""[m/s^2]: what a Crazyflie feels half a metre below another; time of passing under it."""


class TrialKind(StrEnum):
    """Kinds of trials."""

    NOMINAL = "nominal"
    GAP = "radio gap"
    LOST = "radio lost"
    SWAP = "swapped markers"
    STALE = "stale poses"
    BATTERY = "low battery"
    UNARMED = "will not arm"
    PUSH = "downwash"


EXEMPT = frozenset((TrialKind.LOST, TrialKind.UNARMED))
"""Trials in which nothing is asked of the vehicle with the fault."""


def name_of_row(names: Names, row: int) -> str:
    """Return the name of a vehicle in sentences; without names it is cf1, cf2, ..."""
    return names[row] if names else f"cf{row + 1}"


@dataclass(frozen=True, slots=True)
class LicenceTrial:
    """One flight of a licence."""

    kind: TrialKind = TrialKind.NOMINAL
    vehicle: int = 0
    """Row of the vehicle with the fault."""
    start: float = 0.0
    """[s]"""
    other: int = 0
    """Row of the vehicle with which it is exchanged."""
    names: Names = ()
    """Of the vehicles; empty for cf1, cf2, ..."""

    @property
    def words(self) -> str:
        """Return the trial in a few words."""
        who, when = name_of_row(self.names, self.vehicle), f" at {self.start:.1f} s"
        match self.kind:
            case TrialKind.NOMINAL:
                return "nominal"
            case TrialKind.SWAP:
                return f"{self.kind} of {who} and {name_of_row(self.names, self.other)}{when}"
            case TrialKind.STALE:
                return f"{self.kind}{when}"
            case TrialKind.UNARMED:
                return f"{who} {self.kind}"
            case _:
                return f"{self.kind}, {who}{when}"

    @property
    def exempt(self) -> int:
        """Return the row of the vehicle of which nothing is asked; -1 if there is none."""
        return self.vehicle if self.kind in EXEMPT else -1

    def capture_faults(self, names: Names) -> tuple[Fault, ...]:
        """Return the faults of motion capture."""
        if self.kind == TrialKind.SWAP:
            return (Fault("swap", self.start, SWAP_S, (names[self.vehicle], names[self.other])),)
        return (Fault("stale", self.start, STALE_S),) if self.kind == TrialKind.STALE else ()

    def rotor_faults(self, names: Names) -> tuple[Fault, ...]:
        """Return the faults of motors and battery."""
        if self.kind != TrialKind.BATTERY:
            return ()
        return (Fault("battery_sag", self.start, SAG_S, (names[self.vehicle],), SAG),)

    def pushed(self, t: float) -> bool:
        """Return whether the vehicle is pushed down at t [s]."""
        return self.kind == TrialKind.PUSH and self.start <= t < self.start + PUSH_S
