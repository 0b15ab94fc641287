"""Note of what a flight waits for before it begins, if that takes long."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from threading import Timer

from q2q_model.counted import first_of

FIRST_S = 5.0
"""Wait after which the first note is due [s]: the nodes of a small flight start in less."""
AGAIN_S = 30.0
"""Period of the notes after it [s]."""
SHOWN = 3
"""Missing connections that a note names."""
LOADING = "waiting for the code of the nodes to load"
"""Note before nodes can be asked."""


class WaitingNote:
    """Notes of a wait that began at a given time."""

    def __init__(self, begun: float) -> None:
        self._begun = begun
        self._due = begun + FIRST_S

    def update(self, waiting: Sequence[str], now: float) -> str:
        """Return the note due at time now [s] while connections are missing; empty if none is due."""
        if now < self._due:
            return ""
        self._due = now + AGAIN_S
        return f"waiting for the nodes for {now - self._begun:.0f} s: {'; '.join(first_of(waiting, SHOWN))}"


@contextmanager
def noted_if_late(note: Callable[[str], None], seconds: float = FIRST_S) -> Iterator[Callable[[], None]]:
    """Note LOADING after some time [s], in a thread: the start of a node blocks while its code is loaded.

    Yields:
        a function that drops the note.
    """
    timer = Timer(seconds, note, (LOADING,))
    timer.daemon = True
    timer.start()
    try:
        yield timer.cancel
    finally:
        timer.cancel()
