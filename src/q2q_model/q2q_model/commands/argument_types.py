"""Types of arguments for argparse: numbers within bounds, and files and folders to write, or to print."""

import argparse
import math
from collections.abc import Callable
from pathlib import Path

from q2q_model.tunable import LARGEST_INTEGER
from q2q_model.writable_places import STDOUT, writable_file, writable_folder


def whole_number(low: int, high: int = LARGEST_INTEGER) -> Callable[[str], int]:
    """Return a type of arguments: whole numbers from `low` to `high`."""

    def number(given: str) -> int:
        try:
            found = int(given)
        except ValueError:
            found = low - 1
        if low <= found <= high:
            return found
        open_above = high == LARGEST_INTEGER and found < low
        allowed = f">= {low}" if open_above else f"in [{low}, {high}]"
        raise argparse.ArgumentTypeError(f"{given}; must be an integer {allowed}")

    return number


def finite_number(given: str) -> float:
    """Return a finite number: a type of arguments."""
    number = _number(given)
    if not math.isfinite(number):
        raise argparse.ArgumentTypeError(f"{given}; must be a finite number")
    return number


def positive_number(given: str) -> float:
    """Return a number above zero: a type of arguments, refused if it is not finite."""
    number = _number(given)
    if not 0.0 < number < math.inf:
        raise argparse.ArgumentTypeError(f"{given}; must be a finite number above 0")
    return number


def _number(given: str) -> float:
    """Return what a text says; NaN if it is no number."""
    try:
        return float(given)
    except ValueError:
        return math.nan


def output_file(given: str) -> Path:
    """Return the path of a file to write: a type of arguments, refused if it is a folder."""
    return _in_its_words(writable_file, given)


def add_printed_json(parser: argparse.ArgumentParser, words: str) -> None:
    """Add `--json`, with a help in `words`: a file to write, STDOUT if none is named."""
    parser.add_argument("--json", nargs="?", type=output_file, const=STDOUT, metavar="FILE", help=words)


def output_folder(given: str) -> Path:
    """Return the path of a folder to write to: a type of arguments, refused if it is a file."""
    return _in_its_words(writable_folder, given)


def _in_its_words(check: Callable[[Path], Path], given: str) -> Path:
    """Return a checked path, or refuse it in the words of the check: argparse drops those of a ValueError."""
    try:
        return check(Path(given))
    except ValueError as refusal:
        raise argparse.ArgumentTypeError(str(refusal)) from refusal
