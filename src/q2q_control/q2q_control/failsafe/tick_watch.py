"""Watch the wall clock of a live controller, and say what to send when a tick is not answered in time.

| what stays away | what is sent |
|---|---|
| downwash or reference, for hold_s, while states come | the controller's answer to a hover at the setpoint |
| states, for hold_s | the guard's ladder by age: hold, level, land, cut |
| nothing, but stamps stand still: repeated frames | the same ladder: only a newer stamp is news |

The first two come within hold_s and one look (30 + 10 ms), well before the firmware's watchdog (500 ms).
Times are arguments: a test, or a replay, has its own clock.
"""

from dataclasses import replace

import numpy as np

from q2q_control.failsafe.guard import RESTART, Guard
from q2q_control.failsafe.ladder import FallbackParams
from q2q_model.signals.values import CommandStatus, SwarmCommand, SwarmSetpoint, SwarmState


class TickWatch:
    """Time and answer of the newest tick."""

    def __init__(self, guard: Guard, params: FallbackParams) -> None:
        self._guard = guard
        self.params = params
        self._setpoint: SwarmSetpoint | None = None
        self._stamp = -np.inf
        self._at = -np.inf

    def answered(self, setpoint: SwarmSetpoint, now: float) -> None:
        """Note that the tick of a setpoint was answered at wall time now [s], if it was as a newer one."""
        behind = self._stamp - setpoint.t
        if behind == 0.0 or (0.0 < behind <= RESTART and self._guard.newest != setpoint.t):
            return
        self._stamp, self._at, self._setpoint = setpoint.t, now, setpoint

    def due(self, state: SwarmState | None, now: float, ahead: float = 0.0) -> SwarmCommand | None:
        """Return what must be sent at wall time now [s], if anything.

        Args:
            state: the newest that came.
            now: wall time [s].
            ahead: take a tick as late that will be within this time [s], where nothing is going to come.
        """
        age = now - self._at
        if self._setpoint is None:
            return None
        if age + ahead >= self.params.hold_s:
            age = max(age, self.params.hold_s)
        if age >= self.params.hold_s and state is not None and state.t > self._stamp:
            return self._hovering(state, self._setpoint, now)
        return self._guard.without_tick(age)

    def _hovering(self, state: SwarmState, setpoint: SwarmSetpoint, now: float) -> SwarmCommand:
        zero = np.zeros_like(setpoint.pos)
        still = replace(setpoint, t=state.t, vel=zero, acc=zero, yaw_rate=np.zeros_like(setpoint.yaw_rate))
        command = self._guard.update(state, still, None)
        self.answered(still, now - self.params.hold_s)  # the next state is taken as soon as it comes
        sound = command.status <= CommandStatus.SATURATED
        return replace(
            command, status=np.where(sound, CommandStatus.DEGRADED, command.status).astype(np.uint8)
        )
