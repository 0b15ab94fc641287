"""Command lines with an example in their help and a suggestion for a misspelled option or choice.

    arguments -> parsed -> checked -> (heavy imports) -> work -> exit status

Parsing and checking need the standard library only, so help and errors appear without delay.
"""

import argparse
import os
import re
import sys
import warnings
from argparse import Namespace
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from difflib import get_close_matches
from io import TextIOWrapper
from typing import NoReturn

from q2q_model.commands.clean_exit import (
    drop_output,
    exiting_on_signal,
    interrupted_where_safe,
    lost_output,
    output_is_read,
)
from q2q_model.commands.help_text import HelpText
from q2q_model.commands.ros_arguments import split_at_ros
from q2q_model.node.lean_imports import lean_imports

WRONG_CHOICE = re.compile(r"invalid choice: '([^']*)'")
UNKNOWN = re.compile(r"unrecognized arguments: (.*)")
STDERR = 2
"""File descriptor of the standard error."""
INTERRUPTED = 130
"""Exit status after Ctrl-C, as shells have it: 128 + SIGINT."""
CUT_OFF = 141
"""Exit status if nobody reads the output any more (`| head`), as shells have it: 128 + SIGPIPE."""
CLOSED_OUTPUT = "standard output is closed: redirect it, as by > FILE or > /dev/null"
"""Refusal of a command whose results nobody could read."""

Work = Callable[[Namespace], int]
"""Execution of parsed arguments; returns the exit status."""


class UsageError(ValueError):
    """Error for arguments that are valid one by one and contradict each other."""


class CommandLine(argparse.ArgumentParser):
    """Argument parser that suggests the nearest valid option or choice for an unknown one."""

    def __init__(self, program: str, description: str | None, example: str) -> None:
        """Create the parser of a program from its description and one or more lines of example."""
        super().__init__(
            prog=program,
            description=description,
            epilog=f"example:\n{example}",
            formatter_class=HelpText,
            allow_abbrev=False,
        )

    def error(self, message: str) -> NoReturn:
        """Exit with status 2 and one line that suggests the nearest valid word."""
        self.exit(2, f"{self.prog}: {message}{self._hint(message)}; see --help\n")

    def _hint(self, message: str) -> str:
        near = nearest_word(unknown_arguments(message), self.vocabulary())
        return f"; did you mean {near}?" if near else ""

    def vocabulary(self) -> list[str]:
        """Return every option and choice of this command line."""
        options = [word for action in self._actions for word in action.option_strings]
        choices = [str(word) for action in self._actions for word in action.choices or ()]
        return options + choices


def run_command(
    line: CommandLine,
    prepare: Callable[[Namespace], Work],
    argv: Sequence[str] | None,
    *,
    interrupted: str = "interrupted",
    refused: int = 1,
) -> int:
    """Parse a command line, execute it and return the exit status.

    A closed standard output is refused with status 2 before the work.

    Args:
        line: parser.
        prepare: checks the parsed arguments (raises UsageError, ValueError, OSError), imports, and returns
            the work. The namespace also contains the unparsed arguments: `argv`, and `ros_argv` of ROS.
        argv: arguments (None: sys.argv).
        interrupted: message after Ctrl-C; the status is 130.
        refused: exit status after a ValueError or OSError, whose notes are printed before it.
    """
    open_standard_error()
    _replace_unprintable()
    own, of_ros = split_at_ros(argv)
    args = line.parse_args(own, Namespace(argv=own, ros_argv=of_ros))
    if sys.stdout is None:  # `>&-`; the next file that is opened would get its descriptor, and what C prints
        line.error(CLOSED_OUTPUT)
    try:
        with warnings_in_one_line(line.prog):
            with exiting_on_signal(INTERRUPTED), lean_imports():
                work = prepare(args)
            with interrupted_where_safe():
                status = work(args)
            sys.stdout.flush()
            return status
    except KeyboardInterrupt:
        print(f"{line.prog}: {interrupted}", file=sys.stderr)
        return INTERRUPTED
    except UsageError as wrong:
        line.error(str(wrong))
    except (ValueError, OSError) as refusal:
        if isinstance(refusal, BrokenPipeError) and not output_is_read():
            drop_output()
            return CUT_OFF
        print_refusal(line.prog, refusal)
        return refused


def print_refusal(program: str, refusal: ValueError | OSError) -> None:
    """Print an error's notes and its reason, each as one line of a program."""
    if isinstance(refusal, OSError) and not refusal.filename:
        refusal = lost_output() or refusal
    for said in (*getattr(refusal, "__notes__", ()), failure_reason(refusal)):
        print(f"{program}: {said}", file=sys.stderr)


def open_standard_error() -> None:
    """Drop errors where standard error is closed (`2>&-`), also those of processes that this one starts.

    `print` would write them to standard output, and into the next file that is opened what C prints.
    """
    if sys.stderr is None:
        os.dup2(os.open(os.devnull, os.O_RDWR), STDERR)
        os.set_inheritable(STDERR, True)  # noqa: FBT003 - no keyword; dup2 leaves it out if given this one
        sys.stderr = os.fdopen(STDERR, "w", closefd=False)


def _replace_unprintable() -> None:
    """Print `?` for what the encoding of the standard output lacks, such as N²s in ASCII.

    In the locale C.UTF-8 it lacks nothing: paths that are not UTF-8 are printed with their own bytes.
    """
    output = sys.stdout
    if isinstance(output, TextIOWrapper) and (output.errors == "strict" or output.encoding == "ascii"):
        output.reconfigure(errors="replace")


def given_options(args: Namespace) -> list[str]:
    """Return the options on the command line that `run_command` parsed, in their order and without values."""
    return [word.partition("=")[0] for word in args.argv if word.startswith("--")]


def failure_reason(refusal: ValueError | OSError) -> str:
    """Return why a command failed, in one line; of the operating system's errors the path and its words."""
    if isinstance(refusal, OSError) and refusal.strerror and refusal.filename:
        return f"{refusal.filename}: {refusal.strerror}"
    return str(refusal)


@contextmanager
def warnings_in_one_line(program: str) -> Iterator[None]:
    """Print warnings as one line of a program, until the block ends."""

    def show(message: Warning | str, *_: object, **__: object) -> None:
        print(f"{program}: warning: {message}", file=sys.stderr)

    with warnings.catch_warnings():
        warnings.showwarning = show  # the documented hook; restored at the end
        yield


def unknown_arguments(message: str) -> list[str]:
    """Return the unknown arguments in an argparse message, without their values."""
    unknown = UNKNOWN.search(message)
    wrong = unknown[1].split() if unknown else WRONG_CHOICE.findall(message)
    return [word.partition("=")[0] for word in wrong]


def nearest_word(wrong: list[str], known: list[str]) -> str:
    """Return the known word nearest to the first wrong one that has a near one; empty if none is near.

    If options are among the wrong words, the others are their values, and only options can be meant.
    """
    if options := _options_in(wrong):
        wrong, known = options, _options_in(known)
    found = (match for word in wrong for match in get_close_matches(word, known, n=1))
    return next(found, "")


def _options_in(words: list[str]) -> list[str]:
    return [word for word in words if word.startswith("--")]
