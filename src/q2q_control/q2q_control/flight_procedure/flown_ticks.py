"""Join by tick what is sent to vehicles, and know whether the flight procedure lets it be flown.

| mode | a tick is |
|---|---|
| command | `command` |
| setpoint | `reference_safe`, and `interference` if aware |

In both, the procedure sees `state` and hears `reference_safe`.
"""

from dataclasses import dataclass
from typing import Protocol

from q2q_model.node.health import Health
from q2q_model.signals.layout import Signal
from q2q_model.signals.tick_join import TickJoin
from q2q_model.signals.values import Interference, SwarmCommand, SwarmSetpoint, SwarmState

PROCEDURE_TOPICS: dict[str, type[Signal]] = {"reference_safe": SwarmSetpoint, "state": SwarmState}
"""What the procedure takes in every mode."""


def tick_topics(mode: str, *, aware: bool) -> dict[str, type[Signal]]:
    """Return the topics of which a tick is made."""
    if mode == "command":
        return {"command": SwarmCommand}
    downwash: dict[str, type[Signal]] = {"interference": Interference} if aware else {}
    return {"reference_safe": SwarmSetpoint, **downwash}


class Pilotage(Protocol):
    """Flight procedure, as far as signals concern it."""

    def see(self, state: SwarmState) -> None:
        """Take a state."""

    def follows(self, setpoint: SwarmSetpoint) -> bool:
        """Take a setpoint; return whether it is to be flown."""


@dataclass(frozen=True, slots=True)
class FlownTick:
    """One tick for the vehicles: a command, or a setpoint with the downwash to compensate."""

    flown: bool
    """Whether the procedure lets it be flown."""
    command: SwarmCommand | None = None
    setpoint: SwarmSetpoint | None = None
    downwash: Interference | None = None


class FlownTicks:
    """Join of a mode's topics, and what the procedure last said of setpoints."""

    def __init__(self, mode: str, health: Health, *, aware: bool) -> None:
        """Join the topics of a mode; `health` counts ticks."""
        self._topics = tick_topics(mode, aware=aware)
        self._join: TickJoin[Signal] = TickJoin(tuple(self._topics))
        self._health = health
        self._follows = False
        self.procedure: Pilotage | None = None
        """Who decides; None lets nothing be flown."""

    @property
    def topics(self) -> dict[str, type[Signal]]:
        """Return all topics that `take` wants."""
        return self._topics | PROCEDURE_TOPICS

    def take(self, topic: str, stamp_ns: int, value: Signal) -> FlownTick | None:
        """Take a signal; return the tick that it completes."""
        if self.procedure is not None and isinstance(value, SwarmState):
            self.procedure.see(value)
        if isinstance(value, SwarmSetpoint):
            self._follows = self.procedure is not None and self.procedure.follows(value)
        if topic not in self._topics:
            return None
        whole = self._join.put(topic, stamp_ns, value)
        self._health.missed = self._join.missed
        return None if whole is None else self._tick(whole)

    def _tick(self, whole: tuple[Signal, ...]) -> FlownTick:
        self._health.ticks += 1
        command = next((one for one in whole if isinstance(one, SwarmCommand)), None)
        setpoint = next((one for one in whole if isinstance(one, SwarmSetpoint)), None)
        downwash = next((one for one in whole if isinstance(one, Interference)), None)
        return FlownTick(self._follows, command, setpoint, downwash)
