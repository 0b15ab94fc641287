"""Notice of the compilation that delays what a program does for the first time on a machine.

Machine code is stored next to the modules (or in NUMBA_CACHE_DIR), so that later processes load it.
"""

import sys

from numba.core import event

NOTICE = (
    "compiling code for its first run on this machine: half a minute for a flight, minutes for "
    "everything; later starts load it"
)


class CompilationNotice(event.Listener):  # type: ignore[misc]  # numba has no types
    """Listener that prints one line at the first compilation of this process."""

    def __init__(self, program: str) -> None:
        """Start without a compilation; `program` begins the line."""
        self._program = program
        self._printed = False

    def on_start(self, event: event.Event) -> None:  # noqa: ARG002  numba's interface
        """Print the notice once."""
        if not self._printed:
            print(f"{self._program}: {NOTICE}", file=sys.stderr, flush=True)
        self._printed = True

    def on_end(self, event: event.Event) -> None:
        """Do nothing."""


def give_notice_of_compilation(program: str) -> None:
    """Print a notice in the name of a program at the first compilation of this process."""
    event.register("numba:compile", CompilationNotice(program))
