"""Console of rich that prints texts as they are, file names and errors with its markup, "[/tmp]", too."""

import errno
import os

from rich.console import Console


class _PipedConsole(Console):
    """Console that raises BrokenPipeError where nobody reads it any more, as `print` does.

    rich's own, by its documented hook, ends the process with status 1 in place of that of a broken pipe.
    """

    def on_broken_pipe(self) -> None:
        """Raise the error again, for the command line to answer."""
        raise BrokenPipeError(errno.EPIPE, os.strerror(errno.EPIPE))


def plain_console(*, stderr: bool = False, width: int | None = None) -> Console:
    """Return a console without markup, emoji names and highlighting.

    `TextColumn` of a progress bar does not ask its console: give it `markup=False`.
    """
    return _PipedConsole(stderr=stderr, width=width, markup=False, emoji=False, highlight=False)
