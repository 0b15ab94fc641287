"""End a program that is still being imported without a traceback."""

import os
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType


@contextmanager
def ending_at_once(status: int) -> Iterator[None]:
    """Let SIGINT and SIGTERM end this process with a status while nothing has begun that needs to be ended.

    An exception would not do: it can come up in the middle of somebody's import, who may swallow it.
    """

    def end(_: int, __: FrameType | None) -> None:
        os._exit(status)

    before = {number: signal.signal(number, end) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
