"""Work in a forked copy runs in parallel with this process, and its result or error comes back."""

import os
import threading
from time import monotonic

import numpy as np
import pytest

from q2q_model.forked import forked


@pytest.fixture
def alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Have this process seem without other threads: those of pytest's plugins hold no lock that is needed."""
    monkeypatch.setattr(threading, "active_count", lambda: 1)


@pytest.mark.usefixtures("alone")
def test_the_result_of_a_closure_comes_back_from_another_process():
    data = np.arange(3.0)
    result = forked(lambda: (os.getpid(), 2.0 * data))
    pid, doubled = result()
    assert pid != os.getpid()
    assert doubled.tolist() == [0.0, 2.0, 4.0]


@pytest.mark.usefixtures("alone")
def test_the_copy_works_while_this_process_does():
    ours, theirs = os.pipe()
    result = forked(lambda: os.read(ours, 4))  # ends only after the next line of this process
    os.write(theirs, b"done")
    assert result() == b"done"


@pytest.mark.usefixtures("alone")
def test_an_error_is_raised_where_the_result_is_awaited():
    def fail() -> None:
        raise np.linalg.LinAlgError("singular")

    result = forked(fail)
    with pytest.raises(np.linalg.LinAlgError, match="singular"):
        result()


def test_a_process_with_other_threads_does_the_work_itself():
    over = threading.Event()
    other = threading.Thread(target=over.wait)
    other.start()
    try:
        assert forked(os.getpid)() == os.getpid()
    finally:
        over.set()
        other.join()


@pytest.mark.usefixtures("alone")
def test_a_copy_that_is_killed_is_an_error_and_no_endless_wait():
    began = monotonic()
    result = forked(lambda: os.kill(os.getpid(), 9))
    with pytest.raises(ChildProcessError, match="exit code -9"):
        result()
    assert monotonic() - began < 30.0  # a fork and a kill, on any machine
