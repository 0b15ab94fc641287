"""Work in parallel with this process, in a forked copy of it.

The copy has all data, so that only the result is sent. Of the threads of Python only the one that forks lives
on in a copy, and a lock that another one held stays locked there: a process with other threads does the work
itself, later. BLAS restarts its threads after a fork.
"""

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from multiprocessing import current_process, get_context
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from typing import TypeVar

Result = TypeVar("Result")


def forked(work: Callable[[], Result]) -> Callable[[], Result]:
    """Begin work in parallel with this process; return a function that awaits its result or raises its error.

    The result must be picklable, the work need not be.

    Raises:
        ChildProcessError: (the returned function) the copy was killed.
    """
    if threading.active_count() > 1 or current_process().daemon:
        return work
    context = get_context("fork")
    ours, theirs = context.Pipe(duplex=False)
    process = context.Process(target=_send, args=(work, theirs), daemon=True)
    process.start()
    theirs.close()

    def result() -> Result:
        with ours, _explained(process):
            answer: Result | Exception = ours.recv()
        process.join()
        if isinstance(answer, Exception):
            raise answer
        return answer

    return result


@contextmanager
def _explained(process: BaseProcess) -> Iterator[None]:
    """Explain the end of a copy that sent nothing."""
    try:
        yield
    except EOFError:
        process.join()
        raise ChildProcessError(
            f"a process that worked in parallel with this one was ended (exit code {process.exitcode}), "
            "perhaps for lack of memory; free some, then repeat the command"
        ) from None


def _send(work: Callable[[], object], to: Connection) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the process that forked it ends it
    try:
        answer = work()
    except Exception as error:  # noqa: BLE001  raised again where the result is awaited
        answer = error
    with suppress(BrokenPipeError):  # nobody waits for it any more
        to.send(answer)
