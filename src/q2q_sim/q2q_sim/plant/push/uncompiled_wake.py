"""Push of a wake outside the compiled loop, as of a user's class, written into the states between steps."""

from q2q_model.signals.values import Array
from q2q_sim.air.checked_wake import CheckedWake
from q2q_sim.air.wake import AirSetup, Sources, Wake
from q2q_sim.plant.body.state_row import ETA_X, ETA_Y, ETA_Z, F1, POS, QUAT, ROTORS, TORQUE, VEL


class UncompiledWake:
    """Wake of a flight, asked once a physics step."""

    def __init__(self, wake: Wake, setup: AirSetup) -> None:
        """Reset the wake; raise AirError if it fails in a trial."""
        self._wake = wake if isinstance(wake, CheckedWake) else CheckedWake(wake)
        self._step = setup.step
        self._acted_at = -1
        self._wake.reset(setup)

    def act(self, state: Array, steps: int) -> None:
        """Write push and torque into the states (n, STATE_WIDTH) after `steps` steps, once.

        Raises:
            AirError: the class fails, or its answer cannot be flown in.
        """
        if steps == self._acted_at:
            return
        push = self._wake.push(_sources(state, steps * self._step))
        state[:, ETA_X], state[:, ETA_Y], state[:, ETA_Z] = push.acc.T
        state[:, TORQUE] = push.torque
        self._acted_at = steps


def _sources(state: Array, t: float) -> Sources:
    now = state[:, :F1].copy()
    return Sources(t, now[:, POS], now[:, VEL], now[:, QUAT], state[:, ROTORS].sum(axis=1))
