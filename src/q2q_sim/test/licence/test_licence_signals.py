"""Signals that a program sends itself reach its main thread as without the licence."""

from pathlib import Path

import pytest
from flown_programs import flown, hop, log_of, written

pytest.importorskip("cflib", reason="cflib is not installed: requirements/dev.txt has it")

LAND_ON_INTERRUPT = """import _thread, os, signal, threading
    threading.Timer(1.0, {send}).start()
    try:
        time.sleep({sleep})
    except KeyboardInterrupt:
        print("interrupted after", time.monotonic())
    commander.land(0.0, 1.0); time.sleep(1.5); commander.stop()"""


def test_the_handler_of_ctrl_c_is_that_of_python(tmp_path: Path) -> None:
    told = """
import signal
assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
assert signal.signal(signal.SIGINT, print) is signal.default_int_handler
assert signal.signal(signal.SIGINT, signal.SIG_IGN) is print
assert signal.getsignal(signal.SIGINT) == signal.SIG_IGN
"""
    assert flown(written(tmp_path, told)).findings == ()


@pytest.mark.parametrize("send", ["_thread.interrupt_main()", "os.kill(os.getpid(), signal.SIGINT)"])
def test_a_program_that_interrupts_itself_fails_there(tmp_path: Path, send: str) -> None:
    flight = flown(hop(tmp_path, f"import _thread, os, signal\n    {send}\n    time.sleep(1.0)\n    pass"))
    why = {one.rule: one.why for one in flight.findings}
    assert why["program"] == "KeyboardInterrupt, line 13"
    assert why["motors"].startswith("the program failed (KeyboardInterrupt, line 13), which closed the link")


@pytest.mark.parametrize(
    ("send", "sleep", "seconds"),
    [("lambda: os.kill(os.getpid(), signal.SIGINT)", 9.0, 1.0), ("_thread.interrupt_main", 2.0, 2.0)],
)
def test_a_thread_interrupts_the_main_thread_in_its_turn(
    tmp_path: Path, send: str, sleep: float, seconds: float
) -> None:
    """A signal ends a sleep; interrupt_main does not, in Python either."""
    flight = flown(hop(tmp_path, LAND_ON_INTERRUPT.format(send=send, sleep=sleep)))
    assert flight.findings == ()
    log = log_of(flight)
    began, landed = (one.t for one in log.commands if one.asked.kind == "plan")
    assert landed - began == pytest.approx(1.5 + seconds, abs=0.02)
    assert "interrupted" in log.output


def test_a_handler_of_the_program_waits_in_the_turn_of_the_main_thread_which_then_sleeps_on(
    tmp_path: Path,
) -> None:
    told = """
import os, signal, threading, time
seen = []
def note(number, _):
    time.sleep(0.25)
    seen.append((number, round(time.monotonic(), 2)))
def send():
    os.kill(os.getpid(), signal.SIGUSR1)
    seen.append(("sent", round(time.monotonic(), 2)))
    time.sleep(0.5)
    seen.append(("on", round(time.monotonic(), 2)))
signal.signal(signal.SIGUSR1, note)
began = time.monotonic()
threading.Timer(1.0, send).start()
time.sleep(2.0)
seen.append(("end", round(time.monotonic(), 2)))
print(seen)
"""
    log = log_of(flown(written(tmp_path, told)))
    assert log.output.strip() == "[('sent', 1.0), (10, 1.25), ('on', 1.5), ('end', 2.0)]"
