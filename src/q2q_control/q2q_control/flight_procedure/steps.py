"""Steps of a flight, the calls that start transitions, and the acts that a step requires."""

from dataclasses import dataclass
from enum import Enum


class Step(Enum):
    """State of a flight."""

    OFFLINE = "offline"
    """On the ground; a vehicle is not connected."""
    CONNECTED = "connected"
    """On the ground; a check refuses the take-off."""
    CHECKED = "checked"
    """On the ground; take-off would be granted."""
    ARMING = "arming"
    TAKE_OFF = "take-off"
    HOVER = "hover"
    TRANSIT = "transit"
    FLIGHT = "flight"
    HOLD = "hold"
    LANDING = "landing"
    DISARMING = "disarming"
    STOPPED = "stopped"
    """The motors were cut and are locked."""


ON_GROUND = frozenset({Step.OFFLINE, Step.CONNECTED, Step.CHECKED})
FLYING = frozenset({Step.TAKE_OFF, Step.HOVER, Step.TRANSIT, Step.FLIGHT, Step.HOLD})


FOLLOWS_SETPOINTS = frozenset({Step.TRANSIT, Step.FLIGHT, Step.HOLD})
"""Setpoints, or the commands that follow them, are flown."""


class Call(Enum):
    """Request of an operator."""

    START = "start"
    """Fly the present setpoints from where vehicles are, as when held by hand or in simulation."""
    TAKE_OFF = "take_off"
    FLY = "fly"
    HOLD = "hold"
    LAND = "land"
    EMERGENCY = "emergency"


BEGINS_FLIGHT = frozenset({Call.START, Call.TAKE_OFF, Call.FLY})
"""Calls after which vehicles climb or follow setpoints; the others end that."""


class Act(Enum):
    """Action that the procedure orders."""

    WAIT = "let the reference rest at the vehicles"
    ARM = "arm"
    TAKE_OFF = "take off"
    TRANSIT = "transit to the plan's first point"
    STREAM = "stream setpoints"
    START = "start the plan's clock"
    BRAKE = "brake along the plan"
    STOP_STREAM = "stop streaming"
    LAND = "land"
    DISARM = "disarm"
    EMERGENCY = "stop the motors"


@dataclass(frozen=True, slots=True)
class Order:
    """Act ordered of all vehicles."""

    act: Act
    height: float = 0.0
    """Final height of a take-off or landing [m], world."""
    duration: float = 0.0
    """Duration of a take-off or landing [s]."""

    def __str__(self) -> str:
        """Return the order in words."""
        if self.act is Act.TAKE_OFF:
            return f"{self.act.value} to {self.height:.2f} m in {self.duration:.1f} s"
        return f"{self.act.value} in {self.duration:.1f} s" if self.act is Act.LAND else self.act.value
