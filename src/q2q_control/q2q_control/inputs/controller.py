"""Interface of a controller: state, setpoint and predicted downwash in, command out, once per tick."""

from typing import Protocol, runtime_checkable

from q2q_model.signals.values import Interference, SwarmCommand, SwarmSetpoint, SwarmState

LATENCY_S = 0.026
"""Time from a tick's stamp to its command's effect [s]: camera (10 ms) and radio (16) of the room `real`."""

TILT_MAX = 0.35
"""Largest angle of thrust to vertical that a controller commands unless told otherwise [rad]."""

THRUST_LEAST = 0.05
"""Least thrust over weight of a controller's command [-]: with none, or less than MIN_THRUST, 1000 of 65535
(2 to 3 % of the weight), a Crazyflie's motors stop, and nothing holds its attitude."""


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
