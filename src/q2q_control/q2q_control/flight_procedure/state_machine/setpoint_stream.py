"""Stream of setpoints to vehicles, which ends at a jump or a gap of what comes or of what is sent."""

from collections.abc import Mapping

import numpy as np

from q2q_model.signals.values import Array


class SetpointStream:
    """Whether setpoints are streamed, and the first fault since the stream was checked."""

    def __init__(self, step_max: float, timeout_s: float) -> None:
        """Allow moves up to `step_max` [m] a tick and gaps up to `timeout_s` [s]."""
        self._step_max, self._timeout_s = step_max, timeout_s
        self.on = False
        """Setpoints are streamed."""
        self.before = False
        """They were streamed before the stream was last stopped."""
        self._since = -np.inf  # start of the stream
        self._last: Array | None = None  # each vehicle's last position
        self._fault = ""

    @property
    def flies(self) -> bool:
        """Return whether setpoints are streamed and have not jumped."""
        return self.on and not self._fault

    def take(self, setpoint_pos: Array) -> None:
        """Take setpoints at these positions (n, 3) [m]; NaN is a vehicle without one."""
        last = setpoint_pos if self._last is None else self._last
        self._last = np.where(np.isnan(setpoint_pos), last, setpoint_pos)
        if not self.flies:
            return
        moved = float(np.nan_to_num(np.linalg.norm(setpoint_pos - last, axis=-1)).max(initial=0.0))
        if moved > self._step_max:
            self._fault = f"a setpoint jumped by {moved:.2f} m (maximum {self._step_max:.2f} m)"

    def start(self, t: float) -> None:
        """Start the stream at time t [s]; a fault of the last one counts no more."""
        self.on, self._fault, self._since = True, "", t

    def stop(self) -> None:
        """Stop the stream."""
        self.before, self.on = self.on, False

    def take_fault(self, ages: Mapping[str, float], t: float) -> str:
        """Return and clear the fault at time t [s]; empty if there is none.

        Args:
            ages: what is missing, and its age [s]; NaN if it may be. Ages count from the stream's start.
            t: present time [s].
        """
        within = {what: min(age, t - self._since) for what, age in ages.items()}
        silent = (f"{what} for {age:.2f} s" for what, age in within.items() if age > self._timeout_s)
        fault, self._fault = self._fault or next(silent, ""), ""
        return fault
