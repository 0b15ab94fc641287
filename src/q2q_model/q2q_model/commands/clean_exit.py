"""Exit without a traceback: on a signal during imports, and if nobody reads the output any more."""

import os
import select
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

STDOUT = 1
"""File descriptor of the standard output."""


@contextmanager
def exiting_on_signal(status: int) -> Iterator[None]:
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


def output_is_read() -> bool:
    """Return whether somebody still reads the standard output; false after `| head` has ended."""
    events = select.poll()
    events.register(STDOUT, 0)
    return not any(event & select.POLLERR for _, event in events.poll(0))


def drop_output() -> None:
    """Write what is left of the standard output to nowhere, so that the exit does not fail by it."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, STDOUT)
    os.close(nowhere)
