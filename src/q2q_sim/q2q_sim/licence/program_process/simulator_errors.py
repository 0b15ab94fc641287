"""Errors of the simulator itself in a tick: they end the flight and are never reported as the program's."""

import os
import traceback
from dataclasses import dataclass
from multiprocessing.connection import Connection
from typing import NoReturn

from q2q_sim.licence.room.licence_log import escaped
from q2q_sim.licence.room.licence_room import LicenceRoom

ROOM = LicenceRoom.fly.__code__.co_filename
"""File of the room, which takes nothing but packets from a program."""


@dataclass(frozen=True, slots=True)
class SimulatorFailure:
    """Error of the simulator itself in a flight."""

    trace: str
    """Traceback."""

    @property
    def sentence(self) -> str:
        """Return what failed, and the last line of the traceback."""
        return f"the simulator failed, not the program: {self.trace.splitlines()[-1]}"


def is_of_room(error: BaseException) -> bool:
    """Return whether the room failed; a program that calls itself without end may run out of stack there."""
    frames = traceback.extract_tb(error.__traceback__)
    return any(one.filename == ROOM for one in frames) and not isinstance(error, RecursionError)


def end_by(error: BaseException, answer: Connection) -> NoReturn:
    """Send an error of the simulator and end this process."""
    answer.send(SimulatorFailure(escaped("".join(traceback.format_exception(error)).strip())))
    os._exit(1)
