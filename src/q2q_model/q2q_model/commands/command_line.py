"""Command lines with an example in their help and a suggestion for a misspelled option or choice.

    arguments -> parsed -> checked -> (heavy imports) -> work -> exit status

Parsing and checking need the standard library only, so help and errors appear without delay.
"""

import argparse
import math
import re
import sys
import warnings
from argparse import Namespace
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from difflib import get_close_matches
from pathlib import Path
from types import MappingProxyType
from typing import NoReturn

from q2q_model.commands.clean_exit import (
    drop_output,
    exiting_on_signal,
    interrupted_where_safe,
    output_is_read,
)
from q2q_model.commands.help_text import HelpText
from q2q_model.node.lean_imports import lean_imports
from q2q_model.writable_places import writable_file, writable_folder

ROS_ARGS = "--ros-args"
"""Start of the arguments for ROS, which a launch file adds to every program."""
WRONG_CHOICE = re.compile(r"invalid choice: '([^']*)'")
UNKNOWN = re.compile(r"unrecognized arguments: (.*)")
INTERRUPTED = 130
"""Exit status after Ctrl-C, as shells have it: 128 + SIGINT."""
CUT_OFF = 141
"""Exit status if nobody reads the output any more (`| head`), as shells have it: 128 + SIGPIPE."""
LARGEST = 2**63 - 1
"""Largest whole number of a ROS parameter."""

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
    argv: Sequence[str] | None = None,
    *,
    interrupted: str = "interrupted",
    refused: int = 1,
) -> int:
    """Parse a command line, execute it and return the exit status.

    Args:
        line: parser.
        prepare: checks the parsed arguments (raises UsageError, ValueError, OSError), imports, and returns
            the work. The namespace also contains the unparsed arguments: `argv`, and `ros_argv` of ROS.
        argv: arguments (None: sys.argv).
        interrupted: message after Ctrl-C; the status is 130.
        refused: exit status after a ValueError or OSError.
    """
    own, of_ros = split_at_ros(argv)
    args = line.parse_args(own, Namespace(argv=own, ros_argv=of_ros))
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
        print(f"{line.prog}: {failure_reason(refusal)}", file=sys.stderr)
        return refused


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


def require_existing(what: str, *paths: Path | None) -> None:
    """Raise ValueError for the first path that does not exist (None: not given); `what` names its kind."""
    for path in paths:
        if path is not None and not path.exists():
            raise ValueError(f"no {what} at {path}")


def require_apart(
    files: Mapping[str, Path | None], folders: Mapping[str, Path | None] = MappingProxyType({})
) -> None:
    """Raise UsageError if two of the files, named by their arguments, are the same; devices may be.

    It is raised, too, if a file is a folder that another argument asks for.
    """
    seen: dict[Path, str] = {}
    for name, path in files.items():
        if path is None or (path.exists() and not path.is_file()):
            continue
        other = seen.setdefault(path.resolve(), name)
        if other != name:
            raise UsageError(f"{other} and {name} are both {path}: give each a file of its own")
    needed = {name: path.resolve() for name, path in folders.items() if path}
    _require_no_folders(seen, needed | {name: path.parent for path, name in seen.items()})


def _require_no_folders(files: Mapping[Path, str], needed: Mapping[str, Path]) -> None:
    for name, folder in needed.items():
        for place in (folder, *folder.parents):
            if place in files:
                both = f"{files[place]} is the file {place}, which {name} needs as a folder"
                raise UsageError(f"{both}: give one of them another place")


def whole_number(low: int, high: int = LARGEST) -> Callable[[str], int]:
    """Return a type of arguments: whole numbers from `low` to `high`."""
    allowed = f"{low} or more" if high == LARGEST else f"{low} to {high}"

    def number(given: str) -> int:
        try:
            found = int(given)
        except ValueError:
            found = low - 1
        if not low <= found <= high:
            raise argparse.ArgumentTypeError(f"{given}: a whole number is expected, {allowed}")
        return found

    return number


def finite_number(given: str) -> float:
    """Return a finite number: a type of arguments."""
    try:
        number = float(given)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise argparse.ArgumentTypeError(f"{given}: any finite number is allowed")
    return number


def positive_number(given: str) -> float:
    """Return a number above zero: a type of arguments, refused if it is not finite."""
    try:
        number = float(given)
    except ValueError:
        number = math.nan
    if not 0.0 < number < math.inf:
        raise argparse.ArgumentTypeError(f"{given} is no number above 0")
    return number


def output_file(given: str) -> Path:
    """Return the path of a file to write: a type of arguments, refused if it is a folder."""
    return _in_its_words(writable_file, given)


def output_folder(given: str) -> Path:
    """Return the path of a folder to write to: a type of arguments, refused if it is a file."""
    return _in_its_words(writable_folder, given)


def _in_its_words(check: Callable[[Path], Path], given: str) -> Path:
    """Return a checked path, or refuse it in the words of the check: argparse drops those of a ValueError."""
    try:
        return check(Path(given))
    except ValueError as refusal:
        raise argparse.ArgumentTypeError(str(refusal)) from refusal


def outside_ros(arguments: Sequence[str] | None) -> list[str]:
    """Return the words (None: those of sys.argv) before `--ros-args`, and after a `--` that ends these."""
    return split_at_ros(arguments)[0]


def split_at_ros(arguments: Sequence[str] | None) -> tuple[list[str], list[str]]:
    """Return the words (None: those of sys.argv) as of `outside_ros`, and those that are for ROS."""
    own, ros, of_ros = list[str](), list[str](), False
    for word in sys.argv[1:] if arguments is None else arguments:
        if of_ros and word == "--":
            of_ros = False
        elif word == ROS_ARGS:
            of_ros = True
        else:
            (ros if of_ros else own).append(word)
    return own, ros


def unknown_arguments(message: str) -> list[str]:
    """Return the unknown arguments in an argparse message, without their values."""
    unknown = UNKNOWN.search(message)
    wrong = unknown[1].split() if unknown else WRONG_CHOICE.findall(message)
    return [word.partition("=")[0] for word in wrong]


def nearest_word(wrong: list[str], known: list[str]) -> str:
    """Return the known word nearest to the first wrong one that has a near one; empty if none is near."""
    found = (match for word in wrong for match in get_close_matches(word, known, n=1))
    return next(found, "")
