"""Budgets of test files (test/budgets.toml): slow files start first, and a run names those that took longer.

Tests that start last decide when the last worker ends, so they are the short ones. xdist's worksteal gives
each worker a block of the tests, hence the deal: a block takes every n-th file.
"""

import tomllib
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path

import pytest

TABLE = Path(__file__).with_suffix(".toml")


@cache
def budgets() -> tuple[float, Mapping[str, float]]:
    """Return the budget [s] of files that have no own, and of those that have."""
    table = tomllib.loads(TABLE.read_text(encoding="utf-8"))
    return table["others"], table["files"]


def budget_of(file: str) -> float:
    """Return what a test file may take [s], by its path in the repository."""
    others, own = budgets()
    return own.get(file, others)


def file_of(test: str) -> str:
    """Return the file of a test, by the test's name for pytest."""
    return test.partition("::")[0]


def overruns(reports: Iterable[pytest.TestReport]) -> list[str]:
    """Return a line for each file whose tests together took longer than its budget, the worst first."""
    took: dict[str, float] = {}
    for report in reports:
        file = file_of(report.nodeid)
        took[file] = took.get(file, 0.0) + report.duration
    over = {file: seconds for file, seconds in took.items() if seconds > budget_of(file)}
    return [
        f"{file} took {seconds:.0f} s, its budget is {budget_of(file):g} s (test/budgets.toml)"
        for file, seconds in sorted(over.items(), key=lambda one: budget_of(one[0]) - one[1])
    ]


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Put the slow files first where several workers share the tests of more than a change."""
    workers = int(getattr(config, "workerinput", {}).get("workercount", 1))
    if workers > 1 and not config.getoption("changed"):
        place = {test: k for k, test in enumerate(dealt([item.nodeid for item in items], workers))}
        items.sort(key=lambda item: place[item.nodeid])


def dealt(tests: Iterable[str], workers: int) -> list[str]:
    """Return the tests in as many blocks as workers, each from a slow file to a fast one."""
    files: dict[str, list[str]] = {}
    for test in tests:
        files.setdefault(file_of(test), []).append(test)
    dearest = sorted(files, key=budget_of, reverse=True)
    return [test for first in range(workers) for file in dearest[first::workers] for test in files[file]]


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Print what went over its budget."""
    every = [one for some in terminalreporter.stats.values() for one in some]
    for line in overruns(one for one in every if isinstance(one, pytest.TestReport)):
        terminalreporter.write_line(f"slow: {line}", yellow=True)
