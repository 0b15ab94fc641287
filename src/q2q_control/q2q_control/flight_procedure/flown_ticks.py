"""Ticks to send to vehicles, and whether the flight procedure permits them.

| mode | topics of a tick |
|---|---|
| command | `command` |
| setpoint | `reference_safe`, and `interference` if aware |

In both modes the procedure receives `state` and `reference_safe`.
"""

from dataclasses import dataclass
from typing import Protocol

from q2q_model.diagnostics.health import Health
from q2q_model.signals.layout import Signal
from q2q_model.signals.tick_join import TickJoin
from q2q_model.signals.values import Interference, SwarmCommand, SwarmSetpoint, SwarmState

PROCEDURE_TOPICS: dict[str, type[Signal]] = {"reference_safe": SwarmSetpoint, "state": SwarmState}
"""Topics of the procedure in every mode."""


def tick_topics(mode: str, *, aware: bool) -> dict[str, type[Signal]]:
    """Return the topics that make up a tick."""
    if mode == "command":
        return {"command": SwarmCommand}
    downwash: dict[str, type[Signal]] = {"interference": Interference} if aware else {}
    return {"reference_safe": SwarmSetpoint, **downwash}


class ProcedureInputs(Protocol):
    """Inputs of the flight procedure."""

    def store_state(self, state: SwarmState) -> None:
        """Store a state."""

    def store_command(self, command: SwarmCommand) -> None:
        """Store a controller's command."""

    def store_setpoint(self, setpoint: SwarmSetpoint) -> None:
        """Store a setpoint."""

    @property
    def streams(self) -> bool:
        """Return whether ticks are flown now."""


@dataclass(frozen=True, slots=True)
class FlownTick:
    """One tick for the vehicles: a command, or a setpoint with the downwash to compensate."""

    flown: bool
    """The procedure permits it."""
    command: SwarmCommand | None = None
    setpoint: SwarmSetpoint | None = None
    downwash: Interference | None = None


class FlownTicks:
    """Tick join of a mode's topics; a tick is flown if the procedure streams when it is complete."""

    def __init__(self, mode: str, health: Health, *, aware: bool) -> None:
        """Join the topics of a mode; `health` counts ticks."""
        self._topics = tick_topics(mode, aware=aware)
        self._join: TickJoin[Signal] = TickJoin(tuple(self._topics))
        self._health = health
        self.procedure: ProcedureInputs | None = None
        """Flight procedure; None permits no tick."""

    @property
    def topics(self) -> dict[str, type[Signal]]:
        """Return all topics to pass to `take`."""
        return self._topics | PROCEDURE_TOPICS

    def take(self, topic: str, stamp_ns: int, value: Signal) -> FlownTick | None:
        """Add a signal; return the tick that it completes."""
        if self.procedure is not None and isinstance(value, SwarmState):
            self.procedure.store_state(value)
        if self.procedure is not None and isinstance(value, SwarmCommand):
            self.procedure.store_command(value)
        if self.procedure is not None and isinstance(value, SwarmSetpoint):
            self.procedure.store_setpoint(value)
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
        flown = self.procedure is not None and self.procedure.streams
        return FlownTick(flown, command, setpoint, downwash)
