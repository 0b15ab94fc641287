"""Interface of a controller: state, setpoint and predicted downwash in, command out, once per tick."""

from typing import Protocol, runtime_checkable

from q2q_model.signals.values import Interference, SwarmCommand, SwarmImu, SwarmSetpoint, SwarmState


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


@runtime_checkable
class SensingController(Controller, Protocol):
    """Controller that also takes inertial sensors."""

    def sense(self, imu: SwarmImu) -> None:
        """Take the accelerometers and gyroscopes of a tick, after its command."""
