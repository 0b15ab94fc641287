"""Wake given by a user's class, with every answer checked."""

import numpy as np

from q2q_model.own_class import error_line
from q2q_model.signals.checked_array import checked_array
from q2q_model.signals.values import Array
from q2q_sim.air.air_names import AirError
from q2q_sim.air.wake import AirSetup, Push, Sources, Wake

LARGEST_ACC = 1e3
"""Largest acceleration [m/s^2]: a hundred g."""
LARGEST_TORQUE = 1.0
"""Largest torque [N m]: hundreds of times that of a wake's edge."""


class CheckedWake:
    """Wake that raises AirError where its class fails or answers with something that cannot be flown in."""

    def __init__(self, wake: Wake) -> None:
        """Take a wake before its first reset."""
        self._wake = wake
        self._name = f"{type(wake).__module__}:{type(wake).__qualname__}"
        self._count = 0

    def reset(self, setup: AirSetup) -> None:
        """Reset the wake, once more after a trial with vehicles that hover above each other."""
        self._count = setup.count
        self._reset(setup)
        self.push(_stack(setup))
        self._reset(setup)

    def push(self, now: Sources) -> Push:
        """Return the wake's push."""
        try:
            push = self._wake.push(now)
        except (Exception, SystemExit) as error:
            raise self._failed("push", error) from error
        if not isinstance(push, Push):
            raise AirError(f"air {self._name}: push returned a {type(push).__name__}: return a Push")
        acc = self._within("acc", push.acc, LARGEST_ACC, now.t)
        return Push(acc, self._within("torque", push.torque, LARGEST_TORQUE, now.t))

    def _reset(self, setup: AirSetup) -> None:
        try:
            self._wake.reset(setup)
        except (Exception, SystemExit) as error:
            raise self._failed("reset", error) from error

    def _failed(self, what: str, error: BaseException) -> AirError:
        return AirError(f"air {self._name}: {what} raised {error_line(error)}")

    def _within(self, what: str, values: Array, limit: float, t: float) -> Array:
        try:
            given = checked_array(values, (self._count, 3))
        except ValueError as error:
            raise AirError(f"air {self._name}: {what} {error}") from error
        allowed = (np.abs(given) <= limit).all(axis=1)  # not NaN either
        if not allowed.all():
            row = int(np.argmin(allowed))
            raise AirError(
                f"air {self._name}: {what} of vehicle {row} at {t:.3f} s is {given[row]}; must be finite and "
                f"at most {limit:g} in magnitude"
            )
        return given


def _stack(setup: AirSetup) -> Sources:
    """Return vehicles that hover half a metre above each other."""
    n = setup.count
    pos = np.column_stack([np.zeros((n, 2)), 1.0 + 0.5 * np.arange(n)])
    level = np.tile([0.0, 0.0, 0.0, 1.0], (n, 1))
    return Sources(0.0, pos, np.zeros((n, 3)), level, np.full(n, setup.vehicle.hover_thrust))
