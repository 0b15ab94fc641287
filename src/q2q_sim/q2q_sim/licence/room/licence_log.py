"""Log of one flight of a program: the vehicles at every tick, the commands, and the program's end."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from q2q_model.signals.values import Array, Mask, Names
from q2q_sim.licence.client_commands.client_command import ClientCommand, CommandKind
from q2q_sim.licence.room.trials import LicenceTrial, name_of_row

AIRBORNE = 0.06
"""Height from which a vehicle is in the air [m]."""


def escaped(text: str) -> str:
    """Return a text of a program that can be written as UTF-8."""
    return text.encode("utf-8", "backslashreplace").decode("utf-8")


def acts(one: ClientCommand) -> bool:
    """Return whether a command changes what a vehicle does; feeding a watchdog does not."""
    return one.asked.kind != CommandKind.WATCHDOG


@dataclass(frozen=True, slots=True)
class ProgramEnd:
    """How and when a program ended."""

    t: float
    """[s]"""
    status: int = 0
    """Exit status."""
    error: str = ""
    """Last line of its traceback, or the message that it exited with."""
    line: int = 0
    """Line of the program where the error came from."""
    overdue: bool = False
    """Stopped at the time limit."""
    waiting: tuple[int, ...] = ()
    """Lines of the program on which its threads were then, the main thread first."""
    outside: bool = False
    """Stopped because it waited outside Python's clock."""
    caught: str = ""
    """First error of a callback of the program, with its line: cflib catches it and goes on."""
    unknown: str = ""
    """URI that the program opened after those of all vehicles, which stopped it."""

    @property
    def waits(self) -> str:
        """Return where the program waited when it was stopped; empty if nowhere that is known."""
        where = f" on line {' and line '.join(map(str, self.waiting))}" if self.waiting else ""
        place = " outside Python's clock, for input, a socket or a process" if self.outside else ""
        waits = f"it waits{place}{where}" if place or where else ""
        caught = f"an earlier callback failed, and cflib caught it: {self.caught}" if self.caught else ""
        return "; ".join(filter(None, (waits, caught)))


@dataclass(frozen=True, slots=True)
class LicenceLog:
    """Flight of T ticks with n vehicles."""

    uris: tuple[str, ...]
    """By which the program opened the vehicles, (n)."""
    trial: LicenceTrial
    t: Array
    """[s], (T,)."""
    pos: Array
    """True position [m], world, (T, n, 3)."""
    vel: Array
    """[m/s], world, (T, n, 3)."""
    quat: Array
    """x y z w, body to world, (T, n, 4)."""
    yaw_rate: Array
    """[rad/s], (T, n)."""
    thrust: Array
    """Thrust over the weight [-], (T, n)."""
    running: Mask
    """A motor runs, or a controller of the height may run them, (T, n)."""
    state: NDArray[np.int64]
    """State of the supervisor, (T, n)."""
    age: Array
    """Age of the setpoint [s], (T, n)."""
    commands: tuple[ClientCommand, ...]
    opened: tuple[int, ...]
    """Vehicles to which the program opened a link."""
    end: ProgramEnd
    output: str = ""
    """Last lines that the program printed."""
    names: Names = ()
    """Of the vehicles, (n,); empty for cf1, cf2, ..."""

    @property
    def tick(self) -> float:
        """Return the time between ticks [s]: the first one ends at it."""
        return float(self.t[0])

    @property
    def airborne(self) -> Mask:
        """Return which vehicles are in the air, (T, n)."""
        return np.asarray(self.pos[..., 2] > AIRBORNE)

    @property
    def flew(self) -> Mask:
        """Return which vehicles were ever in the air, (n,)."""
        return np.asarray(self.airborne.any(axis=0))

    def of(self, vehicle: int) -> tuple[ClientCommand, ...]:
        """Return the commands to a vehicle."""
        return tuple(one for one in self.commands if one.vehicle == vehicle)

    def last(
        self, vehicle: int, t: float, which: Callable[[ClientCommand], bool] = acts
    ) -> ClientCommand | None:
        """Return the last command of a kind to a vehicle up to t [s]; None if there is none."""
        return next((one for one in reversed(self.of(vehicle)) if one.t <= t and which(one)), None)

    def name(self, vehicle: int) -> str:
        """Return the name of a vehicle in sentences."""
        return name_of_row(self.names, vehicle)
