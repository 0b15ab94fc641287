"""Note that a user or a parent asks a tool to end, and end it where that does no harm."""

import signal
from types import FrameType


class Interruption:
    """Flag that SIGINT or SIGTERM came."""

    def __init__(self) -> None:
        """Catch both signals from now on: they raise nothing by themselves, wherever they come."""
        self._asked = False
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, self._note)

    def check(self) -> None:
        """Raise KeyboardInterrupt if a signal came."""
        if self._asked:
            raise KeyboardInterrupt

    def _note(self, _: int, __: FrameType | None) -> None:
        self._asked = True
