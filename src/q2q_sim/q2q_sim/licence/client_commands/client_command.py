"""Commands of a program as the vehicles receive them, in words."""

from dataclasses import dataclass
from enum import StrEnum

from q2q_model.signals.values import Three


class CommandKind(StrEnum):
    """Kinds of commands."""

    SETPOINT = "setpoint"
    """Makes a vehicle fly."""
    OFF = "off"
    """Stops the motors."""
    PLAN = "plan"
    """Take-off, go-to, landing or trajectory of the high-level commander."""
    RELAX = "relax"
    """Setpoints stop; the high-level commander may take over."""
    EMERGENCY = "emergency"
    WATCHDOG = "watchdog"
    """Starts or feeds the watchdog of the emergency stop."""
    OTHER = "other"
    """Arming, group mask, definition of a trajectory."""


FLIGHT = frozenset((CommandKind.SETPOINT, CommandKind.PLAN))
"""Commands that ask for flight."""


@dataclass(frozen=True, slots=True)
class Asked:
    """Content of a command."""

    kind: CommandKind
    words: str
    pos: Three | None = None
    """Position asked for [m], world; NaN on axes that are not."""
    extent: tuple[Three, Three] | None = None
    """Lowest and highest x, y, z that a plan which the vehicle follows leads through [m], world."""
    yaw_rad: float = 0.0
    """Yaw that the high-level commander is asked for [rad]."""
    refused: str = ""
    """Why the vehicle does not follow; empty if it does."""
    impossible: str = ""
    """What no vehicle can follow; empty if it can."""
    lifts: bool = True
    """False for a setpoint of less thrust than the vehicle's weight."""


@dataclass(frozen=True, slots=True)
class ClientCommand:
    """Command that a vehicle has received."""

    t: float
    """[s]"""
    vehicle: int
    asked: Asked
    line: int
    """Line of the program that sent it; 0 if a library's thread did."""
    closing: bool = False
    """Sent by close_link."""

    @property
    def words(self) -> str:
        """Return the command with its place in the program and the time."""
        if self.closing:
            return f"the closing of the link at {self.t:.2f} s, which sends zero thrust"
        return f"{self.asked.words} at {self.t:.2f} s{self._place}"

    @property
    def words_without_time(self) -> str:
        """Return the command with its place in the program."""
        return f"{self.asked.words}{self._place}"

    @property
    def _place(self) -> str:
        return f", line {self.line}" if self.line else ""
