"""Parse command lines: help with an example, and the nearest right word for a wrong one.

    words -> parsed -> checked -> (imports) -> work -> exit status

Nothing but the standard library is needed before the last check, so that help and refusals come at once.
"""

import argparse
import re
import sys
import warnings
from argparse import Namespace
from collections.abc import Callable, Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import NoReturn

from q2q_model.commands.quiet_end import ending_at_once
from q2q_model.node.lean_imports import lean_imports

ROS_ARGS = "--ros-args"
"""What follows is for ROS: a launch file adds it to whatever it starts."""
WRONG_CHOICE = re.compile(r"invalid choice: '([^']*)'")
UNKNOWN = re.compile(r"unrecognized arguments: (.*)")
INTERRUPTED = 130
"""Exit status after Ctrl-C, as shells have it: 128 + SIGINT."""

Work = Callable[[Namespace], int]
"""Do what a command line asks for; return the exit status."""


class UsageError(ValueError):
    """Words that are right one by one and wrong together."""


class CommandLine(argparse.ArgumentParser):
    """Parse as argparse does, and answer a wrong option or choice with the nearest right one."""

    def __init__(self, program: str, description: str | None, example: str) -> None:
        """Take the program's name, what it does and one or more lines that show how to call it."""
        super().__init__(
            prog=program,
            description=description,
            epilog=f"example:\n{example}",
            formatter_class=argparse.RawDescriptionHelpFormatter,
            allow_abbrev=False,
        )

    def error(self, message: str) -> NoReturn:
        """End with status 2 and one line that names the nearest right word."""
        self.exit(2, f"{self.prog}: {message}{self._hint(message)}; see --help\n")

    def _hint(self, message: str) -> str:
        near = nearest(unknown_words(message), self.words())
        return f"; did you mean {near}?" if near else ""

    def words(self) -> list[str]:
        """Return every option and choice this command line knows."""
        options = [word for action in self._actions for word in action.option_strings]
        choices = [str(word) for action in self._actions for word in action.choices or ()]
        return options + choices


def carry_out(
    line: CommandLine,
    prepare: Callable[[Namespace], Work],
    words: Sequence[str] | None = None,
    *,
    interrupted: str = "interrupted",
    refused: int = 1,
) -> int:
    """Do what a command line asks for; return the exit status.

    Args:
        line: what may be asked for.
        prepare: refuses what cannot be done (UsageError, ValueError, OSError), imports, returns the work.
            What it is given has the words themselves, too, as `words`.
        words: the words (None: this program's own); from `--ros-args` on they are not ours.
        interrupted: what to say after Ctrl-C; the status is 130.
        refused: status after a refusal.
    """
    own = without_ros(words)
    asked = line.parse_args(own, Namespace(words=own))
    warnings.formatwarning = lambda message, *_, **__: f"{line.prog}: warning: {message}\n"
    try:
        with ending_at_once(INTERRUPTED), lean_imports():
            work = prepare(asked)
        return work(asked)
    except KeyboardInterrupt:
        print(f"{line.prog}: {interrupted}", file=sys.stderr)
        return INTERRUPTED
    except UsageError as wrong:
        line.error(str(wrong))
    except (ValueError, OSError) as refusal:
        print(f"{line.prog}: {refusal}", file=sys.stderr)
        return refused


def must_exist(what: str, *paths: Path) -> None:
    """Raise ValueError for the first path that is not there; `what` names its kind."""
    for path in paths:
        if not path.exists():
            raise ValueError(f"no {what} at {path}")


def without_ros(arguments: Sequence[str] | None) -> list[str]:
    """Return the words of a command line (None: this program's own) up to what is meant for ROS itself."""
    words = sys.argv[1:] if arguments is None else list(arguments)
    return words[: words.index(ROS_ARGS)] if ROS_ARGS in words else words


def unknown_words(message: str) -> list[str]:
    """Return the words that an argparse message complains of, without their values."""
    unknown = UNKNOWN.search(message)
    words = unknown[1].split() if unknown else WRONG_CHOICE.findall(message)
    return [word.partition("=")[0] for word in words]


def nearest(wrong: list[str], known: list[str]) -> str:
    """Return the known word nearest to the first wrong one that has any; empty where none is near."""
    found = (match for word in wrong for match in get_close_matches(word, known, n=1))
    return next(found, "")
