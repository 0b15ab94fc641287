"""Mailbox of packets that are sent by its own thread.

cflib's radio driver blocks while the radio is busy. In the mailbox a newer setpoint or pose replaces an older
one, so that a slow radio costs rate, not delay. A packet that cannot be sent is reported, the
next one is sent.
"""

import threading
from collections.abc import Callable
from itertools import count


class Mailbox:
    """Newest packet of each kind, sent by its own thread."""

    def __init__(self, name: str) -> None:
        self._log: list[str] = []
        self._reported: set[type[Exception]] = set()
        self._waiting: dict[str, Callable[[], None]] = {}
        self._serial = count()
        self._change = threading.Condition()
        self._ended = False
        self._thread = threading.Thread(target=self._run, name=f"radio {name}", daemon=True)
        self._thread.start()

    def put(self, kind: str, send: Callable[[], None]) -> None:
        """Queue a packet; it replaces a waiting one of the same kind."""
        with self._change:
            self._waiting.pop(kind, None)
            self._waiting[kind] = send
            self._change.notify()

    def put_once(self, send: Callable[[], None]) -> None:
        """Queue a packet; it is never replaced by another."""
        self.put(f"once {next(self._serial)}", send)

    def put_first(self, send: Callable[[], None]) -> None:
        """Send a packet next and drop all that wait."""
        with self._change:
            self._waiting.clear()
            self.put_once(send)  # in the same hold of the lock, which its thread may take twice

    def log_lines(self) -> list[str]:
        """Return and clear the errors met since, each kind once."""
        lines, self._log = self._log, []
        return lines

    def close(self) -> None:
        """Send what waits, then stop."""
        with self._change:
            self._ended = True
            self._change.notify()
        self._thread.join(timeout=5.0)

    def _run(self) -> None:
        while True:
            with self._change:
                while not self._waiting and not self._ended:
                    self._change.wait()
                if not self._waiting:
                    return
                kind = next(iter(self._waiting))
                send = self._waiting.pop(kind)
            self._try(send)

    def _try(self, send: Callable[[], None]) -> None:
        """Send a packet; whatever that raises, the thread goes on: the next may be an emergency stop."""
        try:
            send()
        except Exception as error:  # noqa: BLE001
            if not isinstance(error, OSError):  # the link reports its own loss
                self._log_once(error)

    def _log_once(self, error: Exception) -> None:
        if type(error) not in self._reported:
            self._reported.add(type(error))
            self._log.append(f"packet not sent: {error!r} (further errors of this type are not logged)")
