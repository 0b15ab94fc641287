"""Waiting of tests for what callbacks do."""

from collections.abc import Callable
from time import monotonic

from rclpy.executors import Executor

TIMEOUT_S = 60.0
"""Longest wait on a busy machine [s]."""


def spin_until(executor: Executor, reached: Callable[[], bool], what: str) -> None:
    """Let callbacks run until something is so; `what` names it in the error."""
    deadline = monotonic() + TIMEOUT_S
    while not reached():
        assert monotonic() < deadline, f"{what}: not within {TIMEOUT_S} s"
        executor.spin_once(timeout_sec=0.05)
