"""Exit without a traceback: on a signal in imports or numba, and if the output cannot be written any more."""

import os
import select
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

STDOUT = 1
"""File descriptor of the standard output."""
UNSAFE = {"numba", "llvmlite", "logging"}
"""Packages that an interrupt waits for: memory that llvmlite was freeing is freed again at the exit, and what
is raised first after a fork, in a hook of logging, is lost."""
AGAIN_S = 0.02
"""Time until one that came within them is tried again [s]."""


@contextmanager
def exiting_on_signal(status: int) -> Iterator[None]:
    """Exit at once with a status on SIGINT or SIGTERM, while nothing needs cleaning up.

    An exception could be swallowed by the module that is being imported.
    """

    def end(_: int, __: FrameType | None) -> None:
        os._exit(status)

    with _handling(end, signal.SIGINT, signal.SIGTERM):
        yield


@contextmanager
def interrupted_where_safe() -> Iterator[None]:
    """Raise KeyboardInterrupt on SIGINT, as usual, but within UNSAFE packages only once they are left."""
    if signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        yield  # ignored, as in the background of a shell
        return

    def interrupt(_: int, frame: FrameType | None) -> None:
        if UNSAFE.isdisjoint(_packages(frame)):
            raise KeyboardInterrupt
        signal.setitimer(signal.ITIMER_REAL, AGAIN_S)

    with _handling(interrupt, signal.SIGINT, signal.SIGALRM):
        try:
            yield
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0.0)


@contextmanager
def _handling(handle: Callable[[int, FrameType | None], None], *numbers: signal.Signals) -> Iterator[None]:
    """Handle signals, and restore their handlers afterwards."""
    before = {number: signal.signal(number, handle) for number in numbers}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _packages(frame: FrameType | None) -> Iterator[str]:
    """Yield the packages of the functions that run, the innermost first."""
    while frame is not None:
        yield str(frame.f_globals.get("__name__")).partition(".")[0]
        frame = frame.f_back


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


def lost_output() -> OSError | None:
    """Return why the standard output cannot be written, if so (a full disk), and drop what is left of it."""
    try:
        sys.stdout.flush()  # fails again: it keeps what it could not write
    except OSError as error:
        drop_output()
        return OSError(error.errno, error.strerror, "standard output")
    return None
