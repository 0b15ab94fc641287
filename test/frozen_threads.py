"""Threads of a process that stand still while its others run, as a thread that hangs does (Linux).

ptrace(2) seizes a single thread and interrupts it: it stays where it is, with every lock that it holds, until
it is released. All calls come from the thread that froze them.
"""

import ctypes
import errno
import os
from pathlib import Path

SEIZE, INTERRUPT, DETACH = 0x4206, 0x4207, 17
"""Requests of ptrace(2)."""
ALL_THREADS = 0x40000000
"""__WALL of waitpid(2): a thread of another process is waited for like a child."""


class FrozenThreads:
    """Threads of a process whose names begin with a prefix, frozen until `release`."""

    def __init__(self, pid: int, prefix: str) -> None:
        """Freeze them.

        Raises:
            ValueError: the process has no such thread.
            OSError: this user may not trace the process.
        """
        self._ptrace = ctypes.CDLL(None, use_errno=True).ptrace
        self._ptrace.argtypes = [ctypes.c_long, ctypes.c_long, ctypes.c_void_p, ctypes.c_void_p]
        self._ptrace.restype = ctypes.c_long
        self._threads = threads_of(pid, prefix)
        if not self._threads:
            raise ValueError(f"process {pid} has no thread {prefix}*")
        for thread in self._threads:
            self._request(SEIZE, thread)
            self._request(INTERRUPT, thread)
            os.waitpid(thread, ALL_THREADS)

    def release(self) -> None:
        """Let the threads go on; those whose process has ended are no more."""
        for thread in self._threads:
            try:
                self._request(DETACH, thread)
            except OSError as error:
                if error.errno != errno.ESRCH:
                    raise
        self._threads = []

    def _request(self, request: int, thread: int) -> None:
        if self._ptrace(request, thread, None, None) == -1:
            number = ctypes.get_errno()
            raise OSError(number, f"ptrace of thread {thread}: {os.strerror(number)}")


def threads_of(pid: int, prefix: str) -> list[int]:
    """Return the ids of a process's threads whose names begin with a prefix, in the order of their start."""
    found = Path(f"/proc/{pid}/task").iterdir()
    return sorted(int(one.name) for one in found if (one / "comm").read_text().startswith(prefix))
