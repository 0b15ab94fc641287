"""Every tool has help with an example, and answers a wrong word with the nearest right one."""

import subprocess
import sys

import pytest
from fresh_checkout import ROOT

TOOLS = {
    "q2q_sim.commands.fly": "--lockstpe",
    "q2q_sim.commands.demo": "--jsno",
    "q2q_sim.commands.report": "--comapre",
    "q2q_sim.commands.crtp": "--latencey",
    "q2q_sim.commands.bag_import": "--uot",
    "q2q_sim.commands.paper": "--onyl",
    "q2q_sim.commands.ablation": "--jsno",
    "q2q_sim.commands.campaign": "--jsno",
    "q2q_sim.commands.policies": "--jsno",
    "q2q_sim.commands.docs": "--chekc",
    "q2q_planner.commands.plan": "--modle",
    "q2q_model.commands.identify": "--vehcile",
    "q2q_model.commands.evaluate": "--modle",
}
"""Each tool with a misspelt option of its own."""


def run(tool: str, *words: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", tool, *words]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False, timeout=300)


def test_every_tool_is_held_to_this():
    found = {
        f"{path.parts[-3]}.tools.{path.stem}"
        for path in (ROOT / "src").glob("*/*/tools/*.py")
        if "CommandLine(" in path.read_text(encoding="utf-8") and path.stem != "command_line"
    }
    assert found == set(TOOLS)


def test_no_tool_parses_its_words_any_other_way():
    others = [
        path
        for folder in ("src", "benchmarks")
        for path in (ROOT / folder).rglob("*.py")
        if "ArgumentParser(" in path.read_text(encoding="utf-8") and "test" not in path.parts
    ]
    assert others == []


@pytest.mark.parametrize("tool", TOOLS)
def test_help_has_an_example_and_a_wrong_word_an_answer(tool: str):
    told = run(tool, "--help")
    assert told.returncode == 0, told.stderr
    assert "example:\n  " in told.stdout
    wrong = run(tool, "x", "--out", "y", TOOLS[tool])
    assert wrong.returncode == 2
    assert "did you mean --" in wrong.stderr or "required" in wrong.stderr
    assert wrong.stderr.count("\n") == 1
