"""Console of rich that prints texts as they are, file names and errors with its markup, "[/tmp]", too."""

from rich.console import Console


def plain_console(*, stderr: bool = False, width: int | None = None) -> Console:
    """Return a console without markup, emoji names and highlighting.

    `TextColumn` of a progress bar does not ask its console: give it `markup=False`.
    """
    return Console(stderr=stderr, width=width, markup=False, emoji=False, highlight=False)
