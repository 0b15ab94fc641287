"""Changes of the fallback phases (q2q_control.failsafe.fallback_phases), for a log.

A vehicle's phase is the status of its command: HOLD, LEVEL, LAND or CUT; else the controller flies it. The
same change of the same vehicles is reported once, and again after SETTLED_S without any phase or in a new
flight; that they are flown again, also after each phase that is reported. After a landing of LANDED commands
all is reported again: each is an event, and the log would end with the first. Shorter ones may flicker, where
two sources with clocks of their own send motion capture.
"""

from dataclasses import dataclass

import numpy as np

from q2q_model.counted import listed
from q2q_model.signals.clock_resets import SET_BACK_S
from q2q_model.signals.values import CommandStatus, Mask, Names, Status, SwarmCommand, rows_by_name

EMERGENCY_CUT = "motors cut by all/emergency: restart this node to fly"
FAILSAFE_CUT = (
    "motors cut after cut_after_s without measurements: to fly, restart this node or set stamps back by "
    f"more than {SET_BACK_S:g} s"
)
SETTLED_S = 10.0
"""Time without a phase after which changes are reported again [s]: one dropout after another is one event."""
LANDED = 30
"""Commands that land a vehicle without one that flies it, 0.3 s at 100 Hz: in flight it sinks by 3 cm."""
FLOWN = CommandStatus.OK
"""Stands for every status without a phase."""
_PHASES = (CommandStatus.HOLD, CommandStatus.LEVEL, CommandStatus.LAND, CommandStatus.CUT)
_PHASE_OF = np.array([one if one in _PHASES else FLOWN for one in CommandStatus], dtype=np.uint8)


@dataclass(frozen=True, slots=True)
class PhaseChange:
    """Phase that some vehicles enter with a command."""

    phase: CommandStatus
    """HOLD, LEVEL, LAND or CUT; FLOWN: the controller flies them again."""
    names: Names

    def __str__(self) -> str:
        """Return the change in words."""
        phase = "the controller flies again" if self.phase is FLOWN else f"failsafe {self.phase.name}"
        return f"{listed(self.names)}: {phase}"


class PhaseChanges:
    """Phase of every vehicle, and the changes that were reported."""

    def __init__(self) -> None:
        self._names: Names = ()
        self._phases: Status = np.zeros(0, dtype=np.uint8)
        self._landing = np.zeros(0)  # commands that land each vehicle
        self._reported: set[PhaseChange] = set()
        self._t = -np.inf  # newest stamp in a flight of a command with a phase [s]
        self._flights = 0  # begun by then

    @property
    def active(self) -> bool:
        """Return whether any vehicle is in a phase."""
        return bool(self._phases.any())

    @property
    def cut(self) -> Names:
        """Return the vehicles whose motors are off."""
        return self._having(CommandStatus.CUT)

    @property
    def brought_down(self) -> Names:
        """Return the vehicles that the failsafe lands, or whose motors are off."""
        return self._having(CommandStatus.LAND) + self.cut

    def __str__(self) -> str:
        """Return the vehicles in each phase in words; empty if there are none."""
        return "; ".join(str(PhaseChange(one, names)) for one in _PHASES if (names := self._having(one)))

    def update(self, command: SwarmCommand, flights: int) -> tuple[PhaseChange, ...]:
        """Return the changes that come with a command and are to be reported.

        Args:
            command: the command.
            flights: number of flights begun (Guard.flights). Stamps do not tell: while a clock that was set
                back is not yet believed, commands have stamps of both clocks in turn.
        """
        phases = _PHASE_OF[command.status]
        if phases.any():
            began = flights != self._flights
            if began or command.t - self._t > SETTLED_S:
                self._names, self._phases = (), phases[:0]
                self._reported.clear()
            self._t, self._flights = command.t if began else max(self._t, command.t), flights
        before = rows_by_name(self._phases, self._names, command.names, FLOWN)
        self._count_landing(command.names, phases)
        self._names, self._phases = command.names, phases
        found = [PhaseChange(one, self._having(one, phases != before)) for one in (FLOWN, *_PHASES)]
        new = tuple(one for one in found if one.names and one not in self._reported)
        self._report(new)
        return new

    def _report(self, new: tuple[PhaseChange, ...]) -> None:
        """Take changes as reported; that vehicles which enter a phase are flown again is then news."""
        fallen = {name for one in new if one.phase is not FLOWN for name in one.names}
        self._reported = {
            one for one in self._reported if one.phase is not FLOWN or fallen.isdisjoint(one.names)
        }
        self._reported.update(new)

    def _count_landing(self, names: Names, phases: Status) -> None:
        """Count the commands that land each vehicle; after many, its flight on is a new event."""
        landing = rows_by_name(self._landing, self._names, names)
        flown = phases == FLOWN
        if (flown & (landing >= LANDED)).any():
            self._reported.clear()
        self._landing = np.where(flown, 0.0, landing + (phases == CommandStatus.LAND))

    def _having(self, phase: CommandStatus, among: Mask | bool = True) -> Names:
        return tuple(self._names[row] for row in np.flatnonzero((self._phases == phase) & among))


def cut_reason(names: Names, *, emergency: bool) -> str:
    """Return why the motors of these vehicles are off."""
    return f"{listed(names)}: {EMERGENCY_CUT if emergency else FAILSAFE_CUT}"
