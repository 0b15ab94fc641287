"""End of a process with its parent, however that ends: nobody is left to fly on."""

import ctypes
import os
import signal
import sys

PR_SET_PDEATHSIG = 1
"""prctl option: signal on the death of the parent (Linux)."""


def die_with_parent() -> None:
    """Request SIGTERM for this process on the death of the thread that started it."""
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGTERM)


def live_with(parent: int) -> None:
    """End with a process, the parent of this one.

    Raises:
        SystemExit: it has ended already.
    """
    die_with_parent()
    if os.getppid() != parent:
        sys.exit(f"process {parent}, which started this one, has ended")
