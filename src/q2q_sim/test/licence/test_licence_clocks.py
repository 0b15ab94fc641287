"""Every clock of a program is that of the room."""

from pathlib import Path

import pytest
from flown_programs import LAND, flown, hop, log_of, written

READ = """
import calendar, time, timeit
from timeit import default_timer
NS = ("time_ns", "monotonic_ns", "perf_counter_ns")
CLOCKS = {
    **{name: getattr(time, name) for name in ("time", "monotonic", "perf_counter")},
    **{name: lambda name=name: getattr(time, name)() / 1e9 for name in NS},
    **{f"{clock}": lambda clock=clock: time.clock_gettime(clock) for clock in (0, 1, 4, 7)},
    "clock_gettime_ns": lambda: time.clock_gettime_ns(time.CLOCK_REALTIME) / 1e9,
    "localtime": lambda: time.mktime(time.localtime()),
    "gmtime": lambda: calendar.timegm(time.gmtime(None)),
    "ctime": lambda: time.mktime(time.strptime(time.ctime())),
    "asctime": lambda: time.mktime(time.strptime(time.asctime())),
    "strftime": lambda: time.mktime(time.strptime(time.strftime("%Y %j %X"), "%Y %j %X")),
    "timeit": default_timer,
}
began = {name: read() for name, read in CLOCKS.items()}
time.sleep(40.0)
print([name for name, read in CLOCKS.items() if abs(read() - began[name] - 40.0) > 1.1])
computed = time.clock_gettime(time.CLOCK_PROCESS_CPUTIME_ID)
print(computed < 40.0, time.process_time() < 40.0, time.gmtime(0).tm_year)
"""
"""40 s of every clock: names of those that are not as long (those of whole seconds by a second), then what is
not replaced."""

ATTRIBUTES = """
import functools, logging, pickle, sys, threading, time, timeit

class Timer:
    clock, wall, wait = time.perf_counter, time.time, time.sleep

logging.Formatter.converter = time.gmtime
logging.basicConfig(stream=sys.stdout, format="%(asctime)s %(message)s", datefmt="%Y")
logging.warning("in UTC")
Timer().wait(1.0)
print(1.0 < Timer().clock() < 2.0, Timer().wall() > 1e9)
print(functools.wraps(time.sleep)(lambda _: None).__name__, time.time.__qualname__, time.monotonic.__module__)
print(threading.Thread(target=time.sleep).name)
print(pickle.loads(pickle.dumps(time.time)) is time.time, time.monotonic == time.perf_counter)
print(timeit.default_timer is time.perf_counter)
for call in (
    time.strftime, lambda: time.strftime("%Y", None), lambda: time.localtime(1, 2), time.sleep,
    lambda: time.sleep(secs=1), lambda: time.time(1), time.clock_gettime,
):
    try:
        print(call())
    except TypeError as error:
        print(error)
"""
"""Clocks as attributes of classes, and calls that Python refuses."""
AS_BUILTINS = ("sleep time time", "Thread-1 (sleep)", "True False", "True")
"""Names, identity."""
REFUSED = (
    "strftime() takes at least 1 argument (0 given)",
    "Tuple or struct_time argument required",
    "localtime() takes at most 1 argument (2 given)",
    "time.sleep() takes exactly one argument (0 given)",
    "time.sleep() takes no keyword arguments",
    "time.time() takes no arguments (1 given)",
    "clock_gettime() takes exactly 1 argument (0 given)",
)
"""What Python says."""


def test_every_clock_of_time_goes_by_the_clock_of_the_room(tmp_path: Path) -> None:
    assert printed(tmp_path, READ) == ["[]", "True True 1970"]


def test_clocks_are_builtins_as_attributes_of_classes_by_name_and_for_wrong_arguments(tmp_path: Path) -> None:
    assert printed(tmp_path, ATTRIBUTES) == ["2026 in UTC", "True True", *AS_BUILTINS, *REFUSED]


def test_dates_and_asyncio_go_by_the_clock_of_the_room(tmp_path: Path) -> None:
    """30 s of waiting, 20 of them in two tasks at a time, take no longer than the flight of as much."""
    pytest.importorskip("cflib", reason="cflib is not installed: requirements/dev.txt has it")
    wait = f"""
    import asyncio, datetime as dt, threading
    from datetime import datetime as now_of
    began, first = time.time(), now_of.now()
    async def rest():
        event, loop = asyncio.Event(), asyncio.get_running_loop()
        threading.Timer(10.0, lambda: loop.call_soon_threadsafe(event.set)).start()
        await asyncio.gather(asyncio.sleep(20.0), event.wait())
        print(round(time.time() - began, 2))
    asyncio.run(rest())
    while now_of.now() - first < dt.timedelta(seconds=30.0):
        time.sleep(0.1)
    print(round(time.time() - began, 1), dt.datetime.utcnow().year, isinstance(first, dt.datetime))
    {LAND}"""
    flight = flown(hop(tmp_path, wait), limit=60.0)
    assert flight.findings == ()
    assert log_of(flight).output.splitlines()[-2:] == ["20.0", "30.0 2026 True"]


def printed(folder: Path, text: str) -> list[str]:
    """Return the lines that a program prints."""
    flight = flown(written(folder, text), limit=60.0)
    assert flight.findings == ()
    return log_of(flight).output.splitlines()
