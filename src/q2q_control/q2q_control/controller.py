"""Interface of a controller: state, setpoint and predicted downwash in, command out, once per tick."""

from typing import Protocol, runtime_checkable

from q2q_model.signals.values import Interference, SwarmCommand, SwarmSetpoint, SwarmState


@runtime_checkable
class Controller(Protocol):
    """Block that maps the signals of one tick to commands for the setpoint's vehicles."""

    def update(
        self, state: SwarmState, setpoint: SwarmSetpoint, interference: Interference | None
    ) -> SwarmCommand:
        """Return the tick's command; `interference` None means ignoring the downwash.

        Rows are matched by name; a vehicle without a state gets the documented fallback.
        """

    def reset(self) -> None:
        """Forget all memory: integrals, warm starts, last commands."""
