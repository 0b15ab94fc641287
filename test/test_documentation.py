"""The documents are true: pages are what the nodes say, links lead somewhere, commands exist."""

import os
import shutil
import subprocess
from functools import cache
from pathlib import Path

import pytest
from documentation import Command, commands, documents, links
from fresh_checkout import ROOT

from q2q_model.mocap_filter import MocapFilterParams
from q2q_model.parameters import tunable_of
from q2q_sim.ros.node_survey import NodeInterface, survey
from q2q_sim.tools.docs import OUT, out_of_date, pages, table
from q2q_sim.tools.processes import find_executable

CHEAP = ("--list", "executables", "--help")
"""Words of commands that only tell something: these really run."""
IN_BASH = ("scripts/test", "scripts/check", "scripts/setup", "scripts/env.sh")
"""Scripts that read their options themselves: what they know stands in their text."""

ALL = commands()


@pytest.fixture(scope="module")
def nodes() -> list[NodeInterface]:
    return survey()


def test_the_node_pages_are_what_the_nodes_declare(nodes: list[NodeInterface]):
    assert out_of_date(pages(nodes), ROOT / OUT) == [], "run scripts/docs"


def test_a_page_tells_every_field_of_the_parameters_with_unit_and_bounds(nodes: list[NodeInterface]):
    page = pages(nodes)["mocap_filter.md"]
    for field in MocapFilterParams.__dataclass_fields__.values():
        row = next(line for line in page.splitlines() if line.startswith(f"| `{field.name}` |"))
        spec = tunable_of(field)
        assert f"`{field.default}`" in row
        assert f"[{spec.unit}]" in row
        assert f"{spec.low:g}" in row


def test_what_a_node_publishes_for_a_vehicle_is_on_its_page(nodes: list[NodeInterface]):
    ports = {node.executable: {port.name for port, _ in node.ports} for node in nodes}
    assert {"state", "mocap", "<name>/pose", "<name>/odom"} <= ports["mocap_filter"]
    assert {"command", "state", "reference_safe", "interference", "<name>/cmd_vel_legacy"} <= ports["pid"]


def test_a_topic_that_takes_a_parameter_says_which(nodes: list[NodeInterface]):
    pid = next(node for node in nodes if node.executable == "pid")
    when = {port.name: words for port, words in pid.ports}
    assert when["interference"] == "`aware`: true"
    assert when["state"] == ""


def test_only_parameters_that_the_node_heeds_may_change_in_flight(nodes: list[NodeInterface]):
    heeded = {
        (node.executable, one.name): yes and not one.read_only
        for node in nodes
        for one, yes in node.parameters
    }
    assert heeded["pid", "k_p_z"]
    assert not heeded["pid", "silent_s"]
    assert not heeded["simulator", "seed"]


def test_a_page_that_is_missing_changed_or_of_no_node_is_out_of_date(tmp_path: Path):
    (tmp_path / "same.md").write_text("a")
    (tmp_path / "changed.md").write_text("b")
    (tmp_path / "left.md").write_text("c")
    wanted = {"same.md": "a", "changed.md": "B", "missing.md": "d"}
    assert out_of_date(wanted, tmp_path) == ["changed.md", "left.md", "missing.md"]


def test_a_bar_in_a_cell_does_not_end_it():
    assert table(("a", "b"), [("|x|", "y")]).splitlines()[2] == r"| \|x\| | y |"


@pytest.mark.parametrize("document", documents(), ids=lambda path: str(path.relative_to(ROOT)))
def test_no_link_is_dead(document: Path):
    dead = [link for link in links(document) if not (document.parent / link).exists()]
    assert dead == []


@pytest.mark.parametrize("command", ALL, ids=lambda one: one.where)
def test_every_command_names_a_program_options_and_files_that_exist(command: Command):
    known = known_words(command.program)
    assert [option for option in command.options if option not in known] == []
    assert [name for name in command.files if not (ROOT / name).exists()] == []


def test_every_parameter_that_a_command_sets_is_declared(nodes: list[NodeInterface]):
    declared = {(node.package, node.executable): {one.name for one, _ in node.parameters} for node in nodes}
    for command in ALL:
        if command.parameters:
            assert set(command.parameters) <= declared[command.words[2], command.words[3]], command.where


@pytest.mark.parametrize(
    "command", [one for one in ALL if set(one.words) & set(CHEAP)], ids=lambda one: one.where
)
def test_commands_that_only_tell_something_run(command: Command):
    done = _run(command.words)
    assert done.returncode == 0, done.stderr.decode()
    assert done.stdout


@cache
def known_words(program: tuple[str, ...]) -> str:
    """Return a text that holds every option of a program; fail where there is no such program."""
    if program[0] == "source":
        return ""
    if program[:1] == ("ros2",):
        assert shutil.which("ros2")
        if len(program) < 4:
            return ""
        path = find_executable(program[2], program[3])
        if (ROOT / OUT / f"{program[3]}.md").exists():  # a node: all it takes are parameters
            return ""
    else:
        path = ROOT / program[0]
        assert path.is_file()
    if program[0] in IN_BASH:
        return path.read_text() + "-k"  # scripts/test hands its words to pytest
    done = _run((str(path), "--help"))
    assert done.returncode == 0, done.stderr.decode()
    return done.stdout.decode()


def _run(words: tuple[str, ...]) -> subprocess.CompletedProcess[bytes]:
    wide = os.environ | {"COLUMNS": "200"}
    return subprocess.run(words, cwd=ROOT, env=wide, capture_output=True, check=False, timeout=300)
