"""Class TimeHelper: the clock of the program is that of the room."""

import time
from collections.abc import Callable

from q2q_sim.licence.crazyflie_py.absent import Absence


class TimeHelper(Absence):
    """Time-related calls; reports of the vehicles arrive while the program sleeps."""

    def __init__(self, spin: Callable[[], None]) -> None:
        self._spin = spin
        self.rateHz: float | None = None
        self.nextTime = 0.0

    def time(self) -> float:
        """Return the time [s]."""
        return time.time()

    def sleep(self, duration: float) -> None:
        """Sleep for a duration [s]."""
        time.sleep(max(duration, 0.0))
        self._spin()

    def sleepForRate(self, rateHz: float) -> None:
        """Sleep so that a loop runs at a rate [Hz]; one that is late catches up."""
        if self.rateHz is None or self.rateHz != rateHz:
            self.rateHz = rateHz
            self.nextTime = self.time() + 1.0 / rateHz
        self.sleep(self.nextTime - self.time())
        self.nextTime += 1.0 / rateHz

    def isShutdown(self) -> bool:
        """Return False: nobody interrupts a licence."""
        return False
