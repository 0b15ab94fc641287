"""Say what an online replanner is: the planned setpoints in, setpoints outside the zones out."""

from typing import Protocol

from q2q_model.signals.values import SwarmSetpoint, SwarmState


class Replanner(Protocol):
    """Block that moves setpoints out of the interference zones, tick by tick."""

    def update(self, setpoint: SwarmSetpoint, state: SwarmState | None) -> SwarmSetpoint:
        """Return the modified setpoints of the tick; `state` None trusts every vehicle to follow."""

    def reset(self) -> None:
        """Forget the modified trajectories; the next update starts on the reference."""
