"""Stamps of commands beside those of frames: a controller that stamps with a clock of its own is named.

In lockstep only the command with the frame's stamp counts; live, the newest does, but stamps that are not set
make each command older than the last one, and no tick is answered in time.
"""

NEAR_NS = 1_000_000_000
"""Live, commands this far from the newest frame [ns] are late ones, or those of a failsafe."""


class CommandStamps:
    """The first of the commands in sequence whose stamps are not those of frames."""

    def __init__(self, *, exact: bool) -> None:
        """Take whether a command must have the frame's stamp, or one near it."""
        self._tolerance_ns = 0 if exact else NEAR_NS
        self._first_foreign: tuple[int, int] | None = None

    def take(self, stamp_ns: int, frame_ns: int) -> None:
        """Take the stamps of a command and of the newest frame [ns]."""
        if abs(stamp_ns - frame_ns) <= self._tolerance_ns:
            self._first_foreign = None
        elif self._first_foreign is None:
            self._first_foreign = stamp_ns, frame_ns

    @property
    def warning(self) -> str:
        """Return which stamps the last commands have, and what to do; empty if they are those of frames."""
        if self._first_foreign is None:
            return ""
        command, frame = (f"{1e-9 * stamp_ns:.3f} s" for stamp_ns in self._first_foreign)
        return (
            f"command: a command is stamped {command}, its frame {frame}: stamp each with its frame's stamp"
        )
