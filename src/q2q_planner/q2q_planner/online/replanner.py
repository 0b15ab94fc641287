"""Interface of an online replanner."""

from typing import Protocol

from q2q_model.signals.values import SwarmSetpoint, SwarmState

LONGEST_GAP = 5.0
"""Gap between stamps, forwards or back, after which a replanner starts as at its first tick [s]."""


class Replanner(Protocol):
    """Block that moves setpoints out of interference zones, tick by tick."""

    def update(self, setpoint: SwarmSetpoint, state: SwarmState | None) -> SwarmSetpoint:
        """Return the modified setpoints of the tick; `state` None assumes ideal tracking."""

    def reset(self) -> None:
        """Forget the modified trajectories; the next update starts on the reference."""
