"""Sleeping and the clocks of Python by the scheduler of a program.

Replaced are `time.sleep`, the clocks of `time` and `timeit`, the functions of `time` that take the present if
none is given, and the present of `datetime.datetime`. Not replaced are processor times, and
`datetime.date.today`. Reading a clock takes CALL_S, so that a loop that waits for a time by reading it ends.
"""

import datetime as dt
import queue
import threading
import time
import timeit
from collections.abc import Callable, Mapping
from functools import update_wrapper
from typing import Self, final

from q2q_sim.licence.program_process.cooperative_scheduler import CooperativeScheduler

CALL_S = 1e-5
"""Time that reading a clock takes [s]."""
EPOCH = 1_767_225_600.0
"""time.time() at the start: 2026-01-01 UTC [s]."""
EPOCHS = {
    time.CLOCK_REALTIME: EPOCH,
    time.CLOCK_TAI: EPOCH,
    time.CLOCK_MONOTONIC: 0.0,
    time.CLOCK_MONOTONIC_RAW: 0.0,
    time.CLOCK_BOOTTIME: 0.0,
}
"""Clocks of `time.clock_gettime` at the start [s]; all others are processor times."""
OF_SECONDS, OF_STRUCT = {"localtime": 0, "gmtime": 0, "ctime": 0}, {"asctime": 0, "strftime": 1}
"""Functions of `time` that take the present, in seconds or as `struct_time`, if the argument at this place is
missing."""


@final
class ClockFunction:
    """Replacement of a builtin of `time`: as a class attribute it does not become a method, as a builtin."""

    def __init__(self, name: str, call: Callable[..., object], count: int | None) -> None:
        """Replace the builtin of that name by a call with `count` arguments; None: it takes any, as given."""
        self._builtin: Callable[..., object] = getattr(time, name)
        self._name, self._call, self._count = name, call, count
        update_wrapper(self, self._builtin)
        del self.__dict__["__wrapped__"]  # no way around the replacement

    def __call__(self, *args: object, **named: object) -> object:
        """Return what the replacement returns; the builtin refuses arguments that it does not take."""
        if named or self._count not in {None, len(args)}:
            return self._builtin(*args, **named)
        return self._call(*args)

    def __reduce__(self) -> str:
        """Return the name in `time`, by which functions are pickled and copied."""
        return self._name


class PatchedDatetime(dt.datetime):
    """Date and time whose present is that of `time.time`."""

    @classmethod
    def now(cls, tz: dt.tzinfo | None = None) -> Self:
        """Return the present."""
        return cls.fromtimestamp(time.time(), tz)

    @classmethod
    def today(cls) -> Self:
        """Return the present."""
        return cls.now()

    @classmethod
    def utcnow(cls) -> Self:
        """Return the present in UTC, without a zone."""
        return cls.now(dt.UTC).replace(tzinfo=None)


def replace_clocks(scheduler: CooperativeScheduler) -> None:
    """Replace sleeping and the clocks for the rest of this process."""

    def read() -> float:
        scheduler.spend(CALL_S)
        return scheduler.now

    _replace_in_time(_sleep(scheduler), read)
    for name, place in OF_SECONDS.items():
        _replace_present(name, place, time.time)
    for name, place in OF_STRUCT.items():
        _replace_present(name, place, time.localtime)
    setattr(timeit, "default_timer", time.perf_counter)  # noqa: B010
    setattr(dt, "datetime", PatchedDatetime)  # noqa: B010
    for module, name in ((threading, "_time"), (queue, "time")):
        setattr(module, name, lambda: scheduler.now)  # deadlines of waits, which are no calls of the program


def _sleep(scheduler: CooperativeScheduler) -> Callable[[float], None]:
    check = time.sleep

    def sleep(seconds: float) -> None:
        check(min(seconds, 0.0))  # raises what Python does for a time below 0, NaN, or no number
        scheduler.sleep(seconds)

    return sleep


def _replace_in_time(sleep: Callable[[float], None], read: Callable[[], float]) -> None:
    """Replace the clocks of `time` by one that begins at 0 s."""
    processor, processor_ns = time.clock_gettime, time.clock_gettime_ns

    def since(epoch: float) -> int:
        return round(epoch) * 10**9 + round(read() * 1e9)

    replaced: Mapping[str, Callable[..., object]] = {
        "sleep": sleep,
        "time": lambda: EPOCH + read(),
        "time_ns": lambda: since(EPOCH),
        "monotonic": read,
        "monotonic_ns": lambda: since(0.0),
        "perf_counter": read,
        "perf_counter_ns": lambda: since(0.0),
        "clock_gettime": lambda clock: EPOCHS[clock] + read() if clock in EPOCHS else processor(clock),
        "clock_gettime_ns": lambda clock: since(EPOCHS[clock]) if clock in EPOCHS else processor_ns(clock),
    }
    of_one_argument = {"sleep", "clock_gettime", "clock_gettime_ns"}
    for name, call in replaced.items():
        setattr(time, name, ClockFunction(name, call, int(name in of_one_argument)))


def _replace_present(name: str, place: int, present: Callable[[], object]) -> None:
    """Let a function of `time` take the present of the replaced clock."""
    function = getattr(time, name)

    def call(*args: object) -> object:
        is_missing = len(args) == place or (args[place:] == (None,) and name in OF_SECONDS)
        return function(*args[:place], present()) if is_missing else function(*args)

    setattr(time, name, ClockFunction(name, call, None))
