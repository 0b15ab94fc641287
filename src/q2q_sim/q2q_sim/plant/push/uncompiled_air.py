"""Air model outside the compiled loop, as a user's class: its push is written into the states each step."""

from q2q_model.signals.values import Array
from q2q_sim.air.air_model import AirModel, AirSetup, Sources
from q2q_sim.air.checked_air_model import CheckedAirModel
from q2q_sim.plant.body.state_row import ETA_X, ETA_Y, ETA_Z, F1, POS, QUAT, ROTORS, TORQUE, VEL


class UncompiledAir:
    """Air model of a flight, asked once a physics step."""

    def __init__(self, air: AirModel, setup: AirSetup) -> None:
        """Reset the air model; raise AirError if it fails in a trial."""
        self._air = air if isinstance(air, CheckedAirModel) else CheckedAirModel(air)
        self._step = setup.step
        self._acted_at = -1
        self._air.reset(setup)

    def act(self, state: Array, steps: int) -> None:
        """Write push and torque into the states (n, STATE_WIDTH) after `steps` steps, once.

        Raises:
            AirError: the class fails, or its output cannot be flown in.
        """
        if steps == self._acted_at:
            return
        push = self._air.push(_sources(state, steps * self._step))
        state[:, ETA_X], state[:, ETA_Y], state[:, ETA_Z] = push.acc.T
        state[:, TORQUE] = push.torque
        self._acted_at = steps


def _sources(state: Array, t: float) -> Sources:
    now = state[:, :F1].copy()
    return Sources(t, now[:, POS], now[:, VEL], now[:, QUAT], state[:, ROTORS].sum(axis=1))
