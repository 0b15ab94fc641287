"""Deferred handling of SIGINT and SIGTERM, so that tools end at a safe point."""

import signal
from types import FrameType


class Interruption:
    """Flag set by SIGINT or SIGTERM."""

    def __init__(self) -> None:
        """Install handlers for both signals that only set the flag."""
        self._asked = False
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, self._note)

    def check(self) -> None:
        """Raise KeyboardInterrupt if a signal has arrived."""
        if self._asked:
            raise KeyboardInterrupt

    def _note(self, _: int, __: FrameType | None) -> None:
        self._asked = True
