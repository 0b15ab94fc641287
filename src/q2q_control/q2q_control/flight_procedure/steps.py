"""Name the steps of a flight, the calls that move it on, and the acts that a step asks for."""

from dataclasses import dataclass
from enum import Enum


class Step(Enum):
    """Where a flight stands."""

    OFFLINE = "offline"
    """On the ground; a vehicle is not connected."""
    CONNECTED = "connected"
    """On the ground; a check refuses the take-off."""
    CHECKED = "checked"
    """On the ground; take-off would be granted."""
    ARMING = "arming"
    TAKE_OFF = "take-off"
    HOVER = "hover"
    GLIDE = "glide"
    FLIGHT = "flight"
    HOLD = "hold"
    LANDING = "landing"
    DISARMING = "disarming"
    STOPPED = "stopped"
    """The motors were stopped for good."""


ON_GROUND = frozenset({Step.OFFLINE, Step.CONNECTED, Step.CHECKED})
FLYING = frozenset({Step.TAKE_OFF, Step.HOVER, Step.GLIDE, Step.FLIGHT, Step.HOLD})


class Call(Enum):
    """What a pilot may ask for."""

    START = "start"
    """Fly the present setpoints from where the vehicles are, as those that a hand or a simulator holds."""
    TAKE_OFF = "take_off"
    FLY = "fly"
    HOLD = "hold"
    LAND = "land"
    EMERGENCY = "emergency"


class Act(Enum):
    """What the procedure has others do."""

    WAIT = "let the reference rest at the vehicles"
    ARM = "arm"
    TAKE_OFF = "take off"
    GLIDE = "glide to the plan's first point"
    STREAM = "stream setpoints"
    START = "start the plan's clock"
    BRAKE = "brake along the plan"
    STOP_STREAM = "stop streaming"
    LAND = "land"
    DISARM = "disarm"
    CUT = "stop the motors"


@dataclass(frozen=True, slots=True)
class Order:
    """Act of all vehicles."""

    act: Act
    height: float = 0.0
    """Where a take-off ends [m], world."""
    duration: float = 0.0
    """Of a take-off or landing [s]."""

    def __str__(self) -> str:
        """Return the order in words."""
        if self.act is Act.TAKE_OFF:
            return f"{self.act.value} to {self.height:.2f} m in {self.duration:.1f} s"
        return f"{self.act.value} in {self.duration:.1f} s" if self.act is Act.LAND else self.act.value
