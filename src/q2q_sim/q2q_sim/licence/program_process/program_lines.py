"""Lines of a program: that of an error, and those that its threads wait on."""

import sys
import threading
import traceback
from types import FrameType
from typing import NamedTuple

PARAM_FILE, GET_VALUE = "cflib/crazyflie/param.py", "get_value"
IN_GET_VALUE = f" in Param.{GET_VALUE}"
"""Added to the KeyError of cflib's get_value, which has only the group or the name without its group."""


class ProgramError(NamedTuple):
    """Error of a program."""

    what: str
    """As Python says it, with IN_GET_VALUE if it is of that."""
    line: int
    """Innermost line of the program's file; 0 if there is none."""


def error_in(file: str, error: BaseException) -> ProgramError:
    """Return what an error is, and the line of a file that it passed."""
    stack = traceback.extract_tb(error.__traceback__)
    frames = [one for one in stack if one.filename == file]
    said = traceback.format_exception_only(error)[-1].strip()
    last = stack[-1]
    if isinstance(error, KeyError) and last.filename.endswith(PARAM_FILE) and last.name == GET_VALUE:
        said += IN_GET_VALUE
    return ProgramError(said, (frames[-1].lineno or 0) if frames else 0)


def waiting_lines(file: str) -> tuple[int, ...]:
    """Return the lines of a file on which threads of this process are, the main thread first."""
    frames = sys._current_frames()  # noqa: SLF001
    main = threading.main_thread().ident
    lines = [_line_in(file, frames[one]) for one in sorted(frames, key=lambda one: (one != main, one))]
    return tuple(dict.fromkeys(line for line in lines if line))


def _line_in(file: str, frame: FrameType) -> int:
    """Return the innermost line of a file that a frame was called from; 0 if there is none."""
    stack = traceback.walk_stack(frame)
    return next((line for one, line in stack if one.f_code.co_filename == file), 0)
