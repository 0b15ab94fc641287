"""Exit without a traceback on a signal during imports."""

import os
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType


@contextmanager
def ending_at_once(status: int) -> Iterator[None]:
    """Exit at once with a status on SIGINT or SIGTERM, while nothing needs cleaning up.

    An exception could be swallowed by the module that is being imported.
    """

    def end(_: int, __: FrameType | None) -> None:
        os._exit(status)

    before = {number: signal.signal(number, end) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
