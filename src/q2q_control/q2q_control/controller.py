"""Say what a controller is: state, setpoint and predicted draft in, command out, once a tick."""

from typing import Protocol

from q2q_model.signals import Interference, SwarmCommand, SwarmSetpoint, SwarmState


class Controller(Protocol):
    """Turn one tick's signals into commands for the vehicles of the setpoint."""

    def update(
        self, state: SwarmState, setpoint: SwarmSetpoint, interference: Interference | None
    ) -> SwarmCommand:
        """Return the tick's command; `interference` None means ignoring the draft.

        Rows are matched by name; a vehicle without a state gets the documented fallback.
        """

    def reset(self) -> None:
        """Forget all memory: integrals, warm starts, last commands."""
