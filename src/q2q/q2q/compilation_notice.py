"""Notice of the compilation that delays the first flights on a machine.

Machine code is stored beside the modules (or in NUMBA_CACHE_DIR), so that later processes load it.
"""

import sys

from numba.core import event


class CompilationNotice(event.Listener):  # type: ignore[misc]  # numba has no types
    """Listener that prints one line at the first compilation of this process."""

    def __init__(self) -> None:
        """Start without a compilation."""
        self._printed = False

    def on_start(self, event: event.Event) -> None:  # noqa: ARG002  numba's interface
        """Print the notice once."""
        if not self._printed:
            print("q2q: compiling for this processor, once: it takes minutes", file=sys.stderr)
        self._printed = True

    def on_end(self, event: event.Event) -> None:
        """Do nothing."""


def give_notice_of_compilation() -> None:
    """Print a notice at the first compilation of this process."""
    event.register("numba:compile", CompilationNotice())
