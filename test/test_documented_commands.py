"""Every command of the documents runs, in the order of its document, in a folder as a reader's.

A tool must end with 0; a flight that falls, as its document says (FALLS), with 1 and that verdict. A node
must come up with the parameters that are written, and end with 0 on SIGINT; the bare commands of the node
pages may be refused in one line that says what is missing. What is not run here stands in ELSEWHERE with the
place where it is. A command of several documents runs in the last of them.
"""

import re
import signal
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest
from documentation import Command, commands, snippets
from fresh_checkout import ROOT
from started_nodes import PATIENCE_S, start, wait_until_spinning

from q2q_sim.tools.domain import own_domain

ELSEWHERE = {
    ("scripts/test",): "the tests themselves",
    ("scripts/check",): "runs before the tests wherever they run (.ci/run)",
    ("scripts/setup",): "test_setup, in a fresh checkout",
    ("scripts/bench",): "some minutes; every benchmark's rows are tested in its own package",
    ("scripts/paper",): "some minutes; test_paper remakes parts",
    ("scripts/campaign",): "hours; test_campaign flies a short one",
    ("scripts/ros2-small",): "test_ros2_small",
    ("source",): "of the shell",
    ("export",): "of the shell",
    ("python",): "test_documentation follows the tutorial of a new model in this process",
    ("ros2", "launch"): "test_launch_files, where launch is installed",
    ("ros2", "pkg"): "test_documentation",
}
"""Programs not run here, and why."""
OF_ANOTHER = {"out/column.q2q": "the tutorial's model, followed in test_documentation"}
"""Files that are made by what is not run here."""
FALLS = {
    "scripts/fly out/mine.yaml --ignoring --bag out/mine_ignoring": "cf2 hit the floor",
    "scripts/fly out/mine.yaml --ignoring --replan": "cf2 hit the floor",
}
"""Flights that fall as their documents say, and the verdict on each."""
LATE = re.compile(r"^verdict: \d+ of \d+ ticks were missed$", re.MULTILINE)
NODES = {path.stem for path in (ROOT / "docs" / "nodes").glob("*.md")} | {"stack"}
BARE = "docs/nodes/"
"""Pages whose command sets no parameter."""
TOOL_PATIENCE_S = 600.0


def is_run_here(command: Command) -> bool:
    """Return whether a command is whole, and of a program that is run here."""
    words = command.words
    placeholder = any(word.isupper() or word.endswith("...") or word.startswith("[") for word in words)
    another = words[:1] in ELSEWHERE or words[:2] in ELSEWHERE or set(words) & set(OF_ANOTHER)
    return not (placeholder or another or "--help" in words or "--list" in words)


LAST = {one.words: one for one in commands() if is_run_here(one)}
HERE = sorted(LAST.values(), key=commands().index)
DOCUMENTS = list(dict.fromkeys(one.where.partition(":")[0] for one in HERE))


@pytest.fixture
def desk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Return a folder that looks like the checkout, with the files that the documents tell to write."""
    monkeypatch.delenv("ROS_DOMAIN_ID", raising=False)
    for name in ("src", "bags"):
        (tmp_path / name).symlink_to(ROOT / name)
    (tmp_path / "out").mkdir()
    for snippet in snippets():
        if snippet.file and not snippet.file.startswith("src/"):
            (tmp_path / snippet.file).write_text(snippet.text)
    with own_domain():
        yield tmp_path


@pytest.mark.parametrize("document", DOCUMENTS)
def test_the_commands_of_a_document_run_in_its_order(document: str, desk: Path) -> None:
    for command in HERE:
        if command.where.partition(":")[0] == document:
            (run_node if command.program[-1] in NODES else run_tool)(command, desk)


def run_tool(command: Command, desk: Path) -> None:
    """Run a tool to its end; late ticks of a live flight are this machine's, not the document's."""
    words = [str(ROOT / word) if word.startswith("scripts/") else word for word in command.words]
    done = subprocess.run(
        words, cwd=desk, capture_output=True, text=True, check=False, timeout=TOOL_PATIENCE_S
    )
    fall = FALLS.get(" ".join(command.words))
    late = "--live" in words and LATE.search(done.stdout)
    assert done.returncode == int(bool(fall or late)), f"{command.where}\n{done.stdout}\n{done.stderr}"
    assert fall is None or f"verdict: {fall}" in done.stdout
    assert "Traceback" not in done.stderr


def run_node(command: Command, desk: Path) -> None:
    """Start a node and end it; a bare one may be refused in one line."""
    process = start(command.words[2], command.words[3], command.words[4:], desk)
    wait_until_spinning(process)
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=PATIENCE_S)
    assert "Traceback" not in said
    refused = process.returncode == 2 and len(said.strip().splitlines()) == 1
    assert process.returncode == 0 or (refused and command.where.startswith(BARE)), f"{command.where}\n{said}"
