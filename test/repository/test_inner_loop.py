"""The way from a change to a verdict: what a change touches, what fits into a minute, what was too slow."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from budgets import TABLE, budget_of, budgets, dealt, file_of, overruns
from changed import ROOT, fitting, module_of, touched
from fresh_checkout import Checkout


def test_help_explains_the_inner_loop_in_five_lines_and_does_no_work(checkout: Checkout):
    output = checkout.shell("scripts/test --help")
    assert output.returncode == 0
    assert sum(line.startswith("scripts/test") for line in output.stdout.splitlines()) == 5
    assert "--changed" in output.stdout
    assert not (checkout.root / ".venv").exists()


@pytest.mark.parametrize(
    ("file", "nearest"),
    [
        (
            "src/q2q_planner/q2q_planner/offline/minimum_snap/minimum_snap.py",
            "src/q2q_planner/test/offline/test_minimum_snap.py",
        ),
        (
            "src/q2q_control/q2q_control/failsafe/fallback_phases.py",
            "src/q2q_control/test/failsafe/test_fallback_phases.py",
        ),
        ("src/q2q_sim/test/loop/test_room.py", "src/q2q_sim/test/loop/test_room.py"),
    ],
)
def test_the_tests_of_a_file_are_the_nearest_to_its_change(file: str, nearest: str):
    assert nearest in touched([file])[:1]


def test_a_change_touches_what_imports_it_through_others_and_nothing_else():
    tests = touched(["src/q2q_planner/q2q_planner/offline/minimum_snap/minimum_snap.py"])
    assert "src/q2q_sim/test/loop/test_closed_loop.py" in tests
    unrelated = "src/q2q_model/test/diagnostics/test_diagnostic_values.py"
    assert (ROOT / unrelated).is_file()
    assert unrelated not in tests


def test_whoever_starts_processes_is_touched_by_every_node():
    assert "test/nodes/test_node_processes.py" in touched(["src/q2q_control/q2q_control/ros/pid_node.py"])


def test_a_file_that_is_no_module_touches_the_tests_that_name_it():
    assert module_of("src/q2q_sim/q2q_sim/scenarios/table6.yaml") is None
    assert "test/nodes/test_killed_nodes.py" in touched(["test/scenarios/low_hover.yaml"])
    assert "test/set_up/test_setup.py" in touched(["scripts/setup"])
    assert "test/repository/test_documentation.py" in touched(["docs/architecture.md"])


def test_a_minute_holds_the_nearest_and_the_first_in_any_case():
    others, _ = budgets()
    files = [f"test/no_such_{k}.py" for k in range(4)]
    assert fitting(files, 2.5 * others) == (files[:2], files[2:])
    assert fitting(files, 0.5 * others) == (files[:1], files[1:])


def test_workers_run_what_is_chosen_and_nothing_else(tmp_path: Path):
    names = ("conftest.py", "pyproject.toml", "test/changed.py", "test/budgets.py", "test/budgets.toml")
    (tmp_path / "test").mkdir()
    for name in names:
        shutil.copy(ROOT / name, tmp_path / name)
    for name in ("changed", "unchanged"):
        (tmp_path / f"test/test_{name}.py").write_text("def test_it(): pass\n")
    (tmp_path / "test/two_hosts.py").write_text("")
    git = ["git", "-c", "user.name=nobody", "-c", "user.email=nobody@example.org"]
    for words in (["init", "--quiet"], ["add", "."], ["commit", "--quiet", "-m", "all"]):
        subprocess.run([*git, *words], cwd=tmp_path, check=True)
    (tmp_path / "test/test_changed.py").write_text("def test_it(): assert True\n")
    pytest_of_two = [sys.executable, "-m", "pytest", "-n", "2", "--changed", "-p", "no:cacheprovider"]
    output = subprocess.run(pytest_of_two, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert "1 passed" in output.stdout, output.stdout + output.stderr


def test_every_file_that_has_a_budget_exists():
    assert [file for file in budgets()[1] if not (ROOT / file).exists()] == []


def test_each_worker_gets_dear_files_first_and_none_in_pieces():
    dear = sorted(budgets()[1], key=budget_of, reverse=True)[:2]
    files = ["test/no_such_0.py", dear[1], "test/no_such_1.py", dear[0]]
    tests = [f"{file}::test_{k}" for file in files for k in range(3)]
    order = dealt(tests, 2)
    assert sorted(order) == sorted(tests)
    assert [file_of(test) for test in order[::3]] == [dear[0], files[0], dear[1], files[2]]
    assert [file_of(test) for test in order[1::3]] == [file_of(test) for test in order[2::3]]


def test_a_file_whose_tests_together_take_longer_than_its_budget_is_named():
    def report(file: str, seconds: float) -> pytest.TestReport:
        where = (file, 1, "test")
        return pytest.TestReport(f"{file}::test", where, {}, "passed", None, "call", duration=seconds)

    most = budget_of("test/no_such.py")
    reports = [report("test/no_such.py", 0.6 * most)] * 2 + [report("test/other.py", 0.9 * most)]
    assert overruns(reports) == [
        f"test/no_such.py took {1.2 * most:.0f} s, its budget is {most:g} s (test/{TABLE.name})"
    ]
