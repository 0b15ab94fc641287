"""Warn of test files that take longer than their budget (test/budgets.toml) at the end of a run."""

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


def overruns(reports: Iterable[pytest.TestReport]) -> list[str]:
    """Return a line for each file whose tests together took longer than its budget, the worst first."""
    took: dict[str, float] = {}
    for report in reports:
        file = report.nodeid.partition("::")[0]
        took[file] = took.get(file, 0.0) + report.duration
    over = {file: seconds for file, seconds in took.items() if seconds > budget_of(file)}
    return [
        f"{file} took {seconds:.0f} s, its budget is {budget_of(file):g} s (test/budgets.toml)"
        for file, seconds in sorted(over.items(), key=lambda one: budget_of(one[0]) - one[1])
    ]


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Print what went over its budget."""
    every = [one for some in terminalreporter.stats.values() for one in some]
    for line in overruns(one for one in every if isinstance(one, pytest.TestReport)):
        terminalreporter.write_line(f"slow: {line}", yellow=True)
