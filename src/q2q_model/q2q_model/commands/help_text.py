"""Text of a command's help: prose filled to the terminal's width, and the default of every option."""

import argparse
import re
import textwrap
from argparse import Action

PARAGRAPHS = re.compile(r"\n\s*\n")
AS_WRITTEN = re.compile(r"^[ |]", re.MULTILINE)
"""Line of an example or of a table."""


class HelpText(argparse.HelpFormatter):
    """Formatter that fills paragraphs, keeps examples and tables as written, and appends defaults."""

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        return "\n\n".join(_filled(part, width, indent) for part in PARAGRAPHS.split(text.strip("\n")))

    def _get_help_string(self, action: Action) -> str:
        text = action.help or ""
        shown = _default_of(action)
        return f"{text} (default {shown})" if shown and "default" not in text else text


def _filled(paragraph: str, width: int, indent: str) -> str:
    if AS_WRITTEN.search(paragraph):
        return textwrap.indent(paragraph, indent)
    return textwrap.fill(
        paragraph,
        width,
        initial_indent=indent,
        subsequent_indent=indent,
        break_long_words=False,
        break_on_hyphens=False,  # an option is not split
    )


def _default_of(action: Action) -> str:
    """Return the default of an argument as it is typed; empty if it has none, or is a switch."""
    default = action.default
    if isinstance(default, bool) or default in (None, "", argparse.SUPPRESS):
        return ""
    words = default if isinstance(default, list | tuple) else [default]
    return " ".join(map(str, words)).replace("%", "%%")  # argparse formats the text
