"""Joystick and keyboard of a licence: whoever looks at them sees a press PRESS_AFTER_S later.

A press lasts PRESS_S; the next comes PRESS_AFTER_S after the first look after it. The first button and any
key are the same.
"""

import time
from typing import Self

from q2q_sim.licence.crazyflie_py.absent import Absence
from q2q_sim.licence.crazyflie_py.time_helper import TimeHelper

PRESS_AFTER_S, PRESS_S = 3.0, 0.2
LOOK_S = 0.01
"""Time between two looks while waiting: genericJoystick.py [s]."""
BUTTONS = 8
BUTTON = 5
"""Button that crazyflie_py looks at."""
KEY = " "


class Joystick(Absence):
    """Joystick with one button that is pressed now and then."""

    def __init__(self, timeHelper: TimeHelper) -> None:
        self.timeHelper = timeHelper
        self.joyID = 0
        self._pressed_at: float | None = None

    def checkIfButtonIsPressed(self) -> bool:
        """Return whether the button is pressed."""
        now = time.time()
        if self._pressed_at is None or now >= self._pressed_at + PRESS_S:
            self._pressed_at = now + PRESS_AFTER_S
        return now >= self._pressed_at

    def waitUntilButtonPressed(self) -> None:
        """Wait until the button has been pressed and let go."""
        while not self.checkIfButtonIsPressed():
            self.timeHelper.sleep(LOOK_S)
        while self.checkIfButtonIsPressed():
            self.timeHelper.sleep(LOOK_S)

    def checkIfAnyButtonIsPressed(self) -> list[int] | None:
        """Return the state of all buttons if one is pressed."""
        if not self.checkIfButtonIsPressed():
            return None
        return [int(button == BUTTON) for button in range(BUTTONS)]

    def waitUntilAnyButtonPressed(self) -> list[int]:
        """Wait until a button has been pressed and let go; return which."""
        self.waitUntilButtonPressed()
        return [int(button == BUTTON) for button in range(BUTTONS)]


class KeyPoller:
    """Keyboard with one key that is pressed now and then."""

    def __init__(self) -> None:
        self._keys = Joystick(TimeHelper(lambda: None))

    def __enter__(self) -> Self:
        """Begin to look."""
        return self

    def __exit__(self, *_: object) -> None:
        """End."""

    def poll(self) -> str | None:
        """Return the key that is pressed."""
        return KEY if self._keys.checkIfButtonIsPressed() else None
