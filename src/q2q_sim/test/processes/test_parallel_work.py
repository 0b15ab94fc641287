"""Parallel work loses nothing by a process that dies, and ends with whoever asked for it."""

import gc
import multiprocessing
import os
import subprocess
import sys
import time
from collections.abc import Generator
from importlib import import_module
from pathlib import Path

import pytest

from q2q_sim.processes import parallel_work
from q2q_sim.processes.parallel_work import Workers, spread_work

TWO = Workers("local", 2)
DEADLY = """
import os
import signal

def work(number):
    if number == 3:
        os.kill(os.getpid(), signal.SIGKILL)
    return number
"""
"""Work that kills its process on number 3."""
UNGUARDED = """
from q2q_sim.processes.parallel_work import Workers, spread_work

print(list(spread_work(Workers("local", 2), abs, [-1, -2, -3], lambda number: "died")))
"""
"""Script that each of its processes would run again."""
KILLED_AT_START = """
import os
import signal
import sys
from pathlib import Path

from q2q_sim.processes.parallel_work import Workers, spread_work

starts = Path(sys.argv[1])
if __name__ != "__main__":
    with starts.open("a") as file:
        file.write("x")
    if starts.stat().st_size == 3:
        os.kill(os.getpid(), signal.SIGKILL)

def work(number):
    if number == 0:
        os.kill(os.getpid(), signal.SIGKILL)
    return number

if __name__ == "__main__":
    print(sorted(spread_work(Workers("local", 2), work, range(6), lambda number: -9)))
"""
"""Guarded script of which the third process is killed while it imports it: the first one alone."""


def test_after_an_interruption_no_process_works_on() -> None:
    """Ctrl-C closes the generator; a pool that is not waited for may do all that is left."""
    results = spread_work(TWO, time.sleep, [0] * 100, print)
    assert isinstance(results, Generator)
    next(results)
    results.close()
    assert multiprocessing.active_children() == []


@pytest.mark.parametrize("jobs", [1, 2])
def test_only_work_that_kills_its_process_alone_counts_as_died(
    jobs: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "deadly_work.py").write_text(DEADLY)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(parallel_work, "freeze_imports", gc.freeze)  # without the imports of a campaign
    work = import_module("deadly_work").work
    done = spread_work(Workers("local", jobs), work, range(6), lambda number: -number)
    assert sorted(done) == [-3, 0, 1, 2, 4, 5]


@pytest.mark.parametrize("by_file", [True, False])
def test_a_script_that_its_processes_cannot_import_is_told_so(by_file: bool, tmp_path: Path) -> None:
    """It is not told that the work on every number died."""
    script = tmp_path / "unguarded.py"
    script.write_text(UNGUARDED)
    command, given = [sys.executable, *([str(script)] if by_file else [])], None if by_file else UNGUARDED
    ended = subprocess.run(command, input=given, capture_output=True, text=True, timeout=60, check=False)
    assert (ended.returncode, ended.stdout) == (1, "")
    assert f"RuntimeError: {parallel_work.NO_START}" in ended.stderr.splitlines()


def test_a_process_that_is_killed_before_it_begins_is_replaced(tmp_path: Path) -> None:
    script = tmp_path / "guarded.py"
    script.write_text(KILLED_AT_START)
    command = [sys.executable, str(script), str(tmp_path / "starts")]
    ended = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert ended.stdout == "[-9, 1, 2, 3, 4, 5]\n", ended.stderr


def test_an_error_of_work_is_raised_as_it_is_by_one_process(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(parallel_work, "freeze_imports", gc.freeze)
    with pytest.raises(OSError, match="Bad file descriptor"):
        list(spread_work(TWO, os.close, [9999], lambda _: pytest.fail("counted as died")))


def test_an_unknown_engine_is_refused() -> None:
    with pytest.raises(ValueError, match="unknown engine 'ray': choose one of local, dask"):
        spread_work(Workers("ray", 1), abs, [1], abs)
