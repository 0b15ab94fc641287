"""Wall-clock deadline of a live controller on its inputs: the command to send when a tick is missing.

| missing | command |
|---|---|
| downwash or reference for hold_after_s, while states come | the controller's, for a hover at the setpoint |
| states, for hold_after_s | the guard's fallback by age: hold, level, land, cut |
| newer stamps: frames are repeated | the same fallback |

The first two take hold_after_s and one timer period (30 + 10 ms), well within the firmware's watchdog
(500 ms). Times are arguments: a test or a replay has its own clock.
"""

from dataclasses import replace

import numpy as np

from q2q_control.failsafe.fallback_params import FallbackParams
from q2q_control.failsafe.guard import Guard
from q2q_model.signals.values import CommandStatus, SwarmCommand, SwarmSetpoint, SwarmState


class InputDeadline:
    """Deadline of the next tick, from stamp, wall time and setpoint of the newest one."""

    def __init__(self, guard: Guard, params: FallbackParams) -> None:
        self._guard = guard
        self.params = params
        self._setpoint: SwarmSetpoint | None = None
        self._stamp = -np.inf
        self._at = -np.inf

    def answered(self, setpoint: SwarmSetpoint, now: float) -> None:
        """Record that the tick of a setpoint was computed at wall time now [s], unless it is left out."""
        if self._guard.newest == setpoint.t != self._stamp:
            self._stamp, self._at, self._setpoint = setpoint.t, now, setpoint

    def due(self, state: SwarmState | None, now: float) -> SwarmCommand | None:
        """Return the command due at wall time now [s]; None if none is.

        Args:
            state: newest state received.
            now: wall time [s].
        """
        age = now - self._at
        if self._setpoint is None:
            return None
        if age >= self.params.hold_after_s and state is not None and state.t > self._stamp:
            command = self._hovering(state, self._setpoint, now)
            if self._guard.newest == state.t:
                return command
        return self._guard.without_tick(age)

    def _hovering(self, state: SwarmState, setpoint: SwarmSetpoint, now: float) -> SwarmCommand:
        zero = np.zeros_like(setpoint.pos)
        still = replace(setpoint, t=state.t, vel=zero, acc=zero, yaw_rate=np.zeros_like(setpoint.yaw_rate))
        command = self._guard.update(state, still, None)
        self.answered(still, now - self.params.hold_after_s)  # use the next state at once
        sound = command.status <= CommandStatus.SATURATED
        return replace(
            command, status=np.where(sound, CommandStatus.DEGRADED, command.status).astype(np.uint8)
        )
