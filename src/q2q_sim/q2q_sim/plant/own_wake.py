"""Air given by a class outside the compiled loop, with its answers checked."""

import numpy as np

from q2q_model.signals.values import Array
from q2q_sim.air.wake import AirError, AirSetup, Push, Sources, Wake
from q2q_sim.plant.quadcopter import ETA, ETA_X, ETA_Y, F1, POS, QUAT, ROTORS, TORQUE, VEL


class OwnWake:
    """Wake of a flight, asked once a physics step."""

    def __init__(self, wake: Wake, setup: AirSetup) -> None:
        """Reset the wake."""
        self._wake, self._setup = wake, setup
        self._name = f"{type(wake).__module__}:{type(wake).__qualname__}"
        self._told = -1
        wake.reset(setup)

    def act(self, state: Array, steps: int) -> None:
        """Write push and torque into the states (n, STATE_WIDTH) after `steps` steps, once.

        Raises:
            AirError: an answer that is not finite, or of the wrong shape.
        """
        if steps == self._told:
            return
        push = self._answer(_sources(state, steps * self._setup.step))
        self._told = steps
        state[:, ETA_X], state[:, ETA_Y], state[:, ETA] = push.acc.T
        state[:, TORQUE] = push.torque

    def _answer(self, now: Sources) -> Push:
        push = self._wake.push(now)
        if not isinstance(push, Push):
            raise AirError(f"air {self._name}: push returned a {type(push).__name__}: return a Push")
        for what, values in push._asdict().items():
            self._check(what, np.asarray(values), now.t)
        return push

    def _check(self, what: str, values: Array, t: float) -> None:
        shape = (self._setup.count, 3)
        if values.shape != shape:
            raise AirError(f"air {self._name}: {what} has the shape {values.shape}: {shape} is needed")
        if not np.isfinite(values).all():
            row = int(np.argmin(np.isfinite(values).all(axis=1)))
            raise AirError(
                f"air {self._name}: {what} of vehicle {row} at {t:.3f} s is {values[row]}: "
                "finite numbers are needed"
            )


def _sources(state: Array, t: float) -> Sources:
    now = state[:, :F1].copy()
    return Sources(t, now[:, POS], now[:, VEL], now[:, QUAT], state[:, ROTORS].sum(axis=1))
