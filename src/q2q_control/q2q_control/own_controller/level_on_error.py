"""Live controller of a user's class: while it fails, the guard levels the vehicles, then lands them."""

import numpy as np

from q2q_control.own_controller.checked_controller import CheckedController, ControllerOutputError
from q2q_model.signals.values import CommandStatus, Interference, SwarmCommand, SwarmSetpoint, SwarmState


class LevelOnError:
    """Controller that returns NaN with status LEVEL where its class fails: the guard then levels."""

    def __init__(self, controller: CheckedController) -> None:
        """Take the controller."""
        self._controller = controller
        self._unreset = ""
        self.error = ""
        """Error of the last update, else of the last reset; empty without one."""

    def reset(self) -> None:
        """Reset the controller."""
        self._unreset = ""
        try:
            self._controller.reset()
        except ControllerOutputError as error:
            self._unreset = str(error)
        self.error = self._unreset

    def update(
        self, state: SwarmState, setpoint: SwarmSetpoint, interference: Interference | None
    ) -> SwarmCommand:
        """Return the controller's command, else NaN with status LEVEL."""
        try:
            command = self._controller.update(state, setpoint, interference)
        except ControllerOutputError as error:
            self.error = str(error)
            return _level(setpoint)
        self.error = self._unreset
        return command


def _level(setpoint: SwarmSetpoint) -> SwarmCommand:
    unknown = np.full(len(setpoint.names), np.nan)
    status = np.full(len(setpoint.names), CommandStatus.LEVEL, dtype=np.uint8)
    return SwarmCommand(setpoint.t, setpoint.names, unknown, unknown, unknown, unknown, status)
