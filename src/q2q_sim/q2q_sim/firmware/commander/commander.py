"""Priority of setpoints: those of clients over those of the high-level commander.

Source: firmware: modules/src/commander.c. A setpoint of lower priority than the present one is ignored. A
client's setpoint stops the high-level plan. `relax` lowers the priority, so that the next plan is accepted.
"""

from enum import IntEnum

from q2q_sim.firmware.commander.setpoint import STOP, Setpoint


class Priority(IntEnum):
    """Sources of setpoints by rank."""

    DISABLE = 0
    HIGH_LEVEL = 1
    CLIENT = 2


class Commander:
    """Present setpoint with its source and time."""

    def __init__(self) -> None:
        self.setpoint: Setpoint = STOP
        self.priority = Priority.DISABLE
        self.set_ms = 0
        """Time from which its age counts [ms]."""

    def offer(self, setpoint: Setpoint, priority: Priority, now_ms: int) -> bool:
        """Accept a setpoint unless a source of higher priority commands; return whether it was accepted."""
        if priority < self.priority:
            return False
        self.setpoint, self.priority, self.set_ms = setpoint, priority, now_ms
        return True

    def relax(self) -> None:
        """Allow any source to take over."""
        self.priority = Priority.HIGH_LEVEL
