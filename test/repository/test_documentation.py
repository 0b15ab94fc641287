"""The documents are true: links lead somewhere, commands exist."""

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from contextlib import redirect_stdout
from functools import cache
from importlib import import_module
from importlib.metadata import entry_points
from io import StringIO
from pathlib import Path
from unittest.mock import patch

import pytest
import yaml
from documentation import Block, Command, commands, documents, is_dead, links, snippets
from fresh_checkout import ROOT

from q2q_model.commands.command_line import CommandLine
from q2q_sim.commands.node_pages import OUT
from q2q_sim.processes.processes import find_executable

NODES_TOGETHER = "stack"
"""A process of several nodes: like a node it takes parameters only."""
DRY_RUNNERS = ("radio", "crazyswarm")
"""Nodes that understand `--dry-run`."""
IN_BASH = ("scripts/test", "scripts/check", "scripts/setup", "scripts/site", "scripts/env.sh")
"""Scripts that read their options themselves: what they know stands in their text."""

OF_OTHERS = ("fastdds",)
"""Programs that are not ours."""
ALL = [one for one in commands() if one.program[0] not in OF_OTHERS and "=" not in one.program[0]]
SNIPPETS = snippets()
SHELL = ("source", "export")
"""Words of the shell itself."""
DRY = [one for one in ALL if one.program[0] not in (*SHELL, *IN_BASH, "python", "scripts/ros2-small")]


SHIPPED_JSON = [
    *ROOT.glob("docs/*.json"),
    *ROOT.glob("docs/notebooks/*.ipynb"),
    *ROOT.glob("src/*/config/*.json"),
]


@pytest.mark.parametrize("file", sorted(SHIPPED_JSON), ids=lambda file: file.name)
def test_every_shipped_file_is_strict_json(file: Path):
    json.loads(file.read_text(encoding="utf-8"), parse_constant=lambda word: pytest.fail(f"{file}: {word}"))


@pytest.mark.parametrize("document", documents(), ids=lambda path: str(path.relative_to(ROOT)))
def test_no_link_is_dead(document: Path):
    assert [link for link in links(document) if is_dead(document, link)] == []


def test_a_heading_that_is_missing_makes_a_link_dead(tmp_path: Path):
    page = tmp_path / "page.md"
    page.write_text("# A heading, with words\n")
    assert not is_dead(page, "#a-heading-with-words")
    assert is_dead(page, "page.md#another")


def test_every_document_is_reached_from_the_index():
    index = ROOT / "docs" / "README.md"
    reached = {(index.parent / link).resolve() for link in links(index)}
    nodes = ROOT / OUT
    assert [page for page in documents()[2:] if page.parent != nodes and page not in {*reached, index}] == []


@pytest.mark.parametrize("snippet", SNIPPETS, ids=lambda one: one.where)
def test_every_snippet_is_of_its_language(snippet: Block):
    if snippet.language == "python":
        compile(snippet.text, snippet.where, "exec")
    else:
        read = json.loads if snippet.language == "json" else yaml.safe_load
        assert isinstance(read(snippet.text), dict)


@pytest.mark.parametrize("command", ALL, ids=lambda one: one.where)
def test_every_command_names_a_program_options_and_files_that_exist(command: Command):
    known = known_words(command.program)
    assert [option for option in command.options if option not in known] == []
    assert [name for name in command.files if not (ROOT / name).exists()] == []


class _ParsedError(Exception):
    """End a tool once its command line is understood."""


@pytest.mark.parametrize("command", DRY, ids=lambda one: one.where)
def test_every_command_of_a_tool_is_understood_by_its_own_parser(command: Command):
    main = tool(command.program)
    if main is None:  # a node: its parameters are looked at above
        return
    words = command.words[len(command.program) :]
    parse = CommandLine.parse_args

    def parsed(made: CommandLine, arguments: object = None, _: object = None) -> None:
        parse(made, list(words) if arguments is None else arguments)
        raise _ParsedError

    with (
        patch.object(CommandLine, "parse_args", parsed),
        patch.object(sys, "argv", ["q2q", *words]),
        pytest.raises((_ParsedError, SystemExit)) as ended,
    ):
        main(list(words))
    if isinstance(ended.value, SystemExit):
        assert "--help" in words
        assert ended.value.code == 0


def tool(program: tuple[str, ...]) -> Callable[[list[str]], int] | None:
    """Return the `main` of a tool by the words that call it; None for a node or another program."""
    if program[0].startswith("scripts/"):
        lines = [line for line in (ROOT / program[0]).read_text().splitlines() if "python -m " in line]
        module = lines[0].partition("python -m ")[2].split()[0] if lines else ""
    elif len(program) == 4:
        found = [one for one in entry_points(group="console_scripts") if one.name == program[3]]
        module = next((one.module for one in found if one.module.startswith(program[2])), "")
    else:
        module = ""
    if ".commands." not in module or module.endswith("_nodes"):
        return None
    main: Callable[[list[str]], int] = import_module(module).main
    return main


@cache
def known_words(program: tuple[str, ...]) -> str:
    """Return a text that holds every option of a program; fail where there is no such program."""
    if program[0] in SHELL:
        return ""
    if program[0] == "python":
        return "-c"
    if program[:1] == ("ros2",):
        assert shutil.which("ros2")
        if len(program) < 4:
            return ""
        path = find_executable(program[2], program[3])
        if (
            program[3] == NODES_TOGETHER or (ROOT / OUT / f"{program[3]}.md").exists()
        ):  # a node: all it takes are parameters, but for one word of two nodes
            return "--dry-run" if program[3] in DRY_RUNNERS else ""
    else:
        path = ROOT / program[0]
        assert path.is_file()
    if program[0] in IN_BASH:
        return path.read_text() + "-k"  # scripts/test hands its words to pytest
    main = tool(program)
    return help_of(main) if main else _help_of_script(path)


def help_of(main: Callable[[list[str]], int]) -> str:
    """Return what a tool answers to --help, said in this process."""
    output = StringIO()
    with patch.dict(os.environ, COLUMNS="200"), redirect_stdout(output), pytest.raises(SystemExit) as ended:
        main(["--help"])
    assert ended.value.code == 0
    return output.getvalue()


def _help_of_script(path: Path) -> str:
    wide = os.environ | {"COLUMNS": "200"}
    done = subprocess.run(
        [str(path), "--help"], cwd=ROOT, env=wide, capture_output=True, text=True, check=False, timeout=300
    )
    assert done.returncode == 0, done.stderr
    return done.stdout
