"""Decide whose setpoint is flown: the high-level commander's, or a client's, which has priority.

Source: firmware: modules/src/commander.c. A setpoint of lower priority than the present one is not taken. A
client's setpoint stops the high-level plan. `relax` gives the priority back, so that the next plan is taken.
"""

from enum import IntEnum

from q2q_sim.firmware.commander.setpoint import STOP, Setpoint


class Priority(IntEnum):
    """Rank the sources of setpoints."""

    DISABLE = 0
    HIGH_LEVEL = 1
    CLIENT = 2


class Commander:
    """Hold the setpoint of the moment, who set it, and when."""

    def __init__(self) -> None:
        self.setpoint: Setpoint = STOP
        self.priority = Priority.DISABLE
        self.set_ms = 0
        """Age counts from here [ms]."""

    def offer(self, setpoint: Setpoint, priority: Priority, now_ms: int) -> bool:
        """Take a setpoint if nobody of higher priority commands; return whether it was taken."""
        if priority < self.priority:
            return False
        self.setpoint, self.priority, self.set_ms = setpoint, priority, now_ms
        return True

    def relax(self) -> None:
        """Let any source of setpoints take over."""
        self.priority = Priority.HIGH_LEVEL
