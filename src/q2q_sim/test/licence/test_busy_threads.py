"""Threads that compute without waiting let time pass, and the others go on."""

from pathlib import Path

import pytest
from flown_programs import flown, log_of, written

WAITS = """
import threading, time
done = False
def wait():
    while not done:
        pass
    print("thread at", round(time.monotonic(), 1))
waiting = threading.Thread(target=wait)
waiting.start()
time.sleep(1.0)
done = True
waiting.join()
print("main at", round(time.monotonic(), 1))
"""
COMPUTES = """
import threading, time
def compute():
    began = time.process_time()
    while time.process_time() < began + 1.0:
        pass
    print(time.monotonic())
{run}
"""


def test_a_thread_that_waits_in_a_loop_for_another_sees_what_that_does(tmp_path: Path) -> None:
    output = log_of(flown(written(tmp_path, WAITS))).output
    assert output.split("\n")[:2] in [
        [f"thread at {t}", f"main at {t}"]
        for t in (1.0, 1.1, 1.2)  # its turns last 0.2 s
    ]


@pytest.mark.parametrize("run", ["compute()", "threading.Thread(target=compute).start()"])
def test_a_second_of_computing_passes_but_for_its_first_part(tmp_path: Path, run: str) -> None:
    """Five looks at the thread are in a second; the first one only notes that it computes."""
    output = log_of(flown(written(tmp_path, COMPUTES.format(run=run)))).output
    assert float(output) == pytest.approx(0.8, abs=0.201)
