"""`--changed`: run the tests that a change can touch, nearest first, as many as fit into a minute.

A test file is touched by the modules that it names, and by what those import (grimp's graph of imports, as
import-linter reads it). Whoever starts processes is touched by every node. A changed file that is no module
touches the test files that name it. Time is counted by the files' budgets.
"""

import ast
import re
import subprocess
from collections import deque
from collections.abc import Iterable, Sequence
from functools import cache
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from budgets import budget_of

if TYPE_CHECKING:
    from grimp import ImportGraph
    from xdist.workermanage import WorkerController

ROOT = Path(__file__).parents[1]
PACKAGES = ("q2q_model", "q2q_planner", "q2q_control", "q2q_sim", "q2q")
TESTS = ("src/*/test", "test")
STARTER = "q2q_sim.processes.processes"
"""The module that starts the nodes, which it does not import."""
RUN_S = 45.0
"""Time of the tests themselves; set-up, the graph of imports and collection take the rest of a minute."""
CHOSEN = "changed"
"""What a worker's input calls the chosen files."""


def pytest_addoption(parser: pytest.Parser) -> None:
    """Declare the options."""
    group = parser.getgroup("changed")
    group.addoption("--changed", action="store_true", help="run what an uncommitted change can touch")
    group.addoption("--since", metavar="COMMIT", default="HEAD", help="with --changed: since this commit")


def pytest_configure(config: pytest.Config) -> None:
    """Put the touched test files in the place of all; workers of xdist get them."""
    if not config.getoption("changed"):
        return
    if hasattr(config, "workerinput"):
        config.args[:] = config.workerinput[CHOSEN]
        return
    files = changed_files(config.getoption("since"))
    chosen, left = fitting(touched(files), RUN_S * workers(config))
    if not chosen:
        pytest.exit("no test is touched by what changed" if files else "nothing changed", returncode=0)
    config.args[:] = [str(ROOT / one) for one in chosen]
    print(f"changed: {len(files)} files touch {len(chosen) + len(left)} test files; run: {len(chosen)}")
    if left:
        print(f"changed: left for scripts/test, to stay within a minute: {' '.join(left)}")


@pytest.hookimpl(optionalhook=True)  # of xdist, which need not be loaded
def pytest_configure_node(node: "WorkerController") -> None:
    """Tell a worker the files: by itself it would take the command line, which names none."""
    node.workerinput[CHOSEN] = list(node.config.args)


def workers(config: pytest.Config) -> int:
    """Return how many tests run at a time."""
    return len(getattr(config.option, "tx", None) or [None])


def changed_files(since: str) -> list[str]:
    """Return the files that differ from a commit, and those that git does not know yet."""
    found = [
        subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=True).stdout.splitlines()
        for words in (
            ["git", "diff", "--name-only", since],
            ["git", "ls-files", "--others", "--exclude-standard"],
        )
    ]
    return sorted({*found[0], *found[1]})


def fitting(files: Sequence[str], seconds: float) -> tuple[list[str], list[str]]:
    """Return the first files whose budgets fit into a time, and the others; the first fits in any case."""
    chosen: list[str] = []
    for one in files:
        seconds -= budget_of(one)
        if seconds < 0.0 and chosen:
            break
        chosen.append(one)
    return chosen, list(files[len(chosen) :])


def touched(files: Iterable[str]) -> list[str]:
    """Return the test files that changed files touch, nearest first."""
    paths = [path for folder in TESTS for path in ROOT.glob(f"{folder}/**/test_*.py")]
    tests = sorted(str(path.relative_to(ROOT)) for path in paths)
    modules = [name for name in map(module_of, files) if name]
    steps, namesakes = _steps_from(modules), {f"test_{name.rpartition('.')[2]}" for name in modules}
    words = [word for one in files if not module_of(one) for word in _words_for(Path(one))]
    found = {}
    for test in tests:
        sources = _sources_of(ROOT / test)
        names = set().union(*(_modules_named_in(one) for one in sources))
        text = "".join(one.read_text(encoding="utf-8") for one in sources)
        near = min((steps.get(name, inf) for name in names), default=inf)
        if test in files or Path(test).stem in namesakes:
            near = -1.0
        elif any(str(one.relative_to(ROOT)) in files for one in sources) or any(one in text for one in words):
            near = 0.0
        found[test] = near
    return sorted((one for one in tests if found[one] < inf), key=lambda one: (found[one], budget_of(one)))


def _words_for(path: Path) -> tuple[str, ...]:
    """Return words by which tests name a file that is no module; scenarios and models go by their stems."""
    if not path.suffix:
        return (str(path),)
    stem = (f'"{path.stem}"',) if path.parts[0] == "src" else ()
    return (*stem, path.name, f"*{path.suffix}")


def module_of(file: str) -> str | None:
    """Return the module that a file is, by its path in the repository; None for what is none."""
    found = re.fullmatch(r"src/\w+/(q2q_\w+(?:/\w+)*)\.py", file)
    return found[1].replace("/", ".").removesuffix(".__init__") if found else None


@cache
def _graph() -> "ImportGraph":
    import grimp  # only here: every run of pytest reads this file

    graph = grimp.build_graph(*PACKAGES, cache_dir=str(ROOT / "build/grimp"))
    for name in graph.modules:
        if name.endswith("_node"):
            graph.add_import(importer=STARTER, imported=name)
    return graph


def _steps_from(modules: Iterable[str]) -> dict[str, float]:
    """Return how many imports lead from each module to the nearest of these."""
    graph = _graph()
    steps = {name: 0.0 for name in modules if name in graph.modules}
    waiting = deque(steps)
    while waiting:
        here = waiting.popleft()
        for user in graph.find_modules_that_directly_import(here) - steps.keys():
            steps[user] = steps[here] + 1.0
            waiting.append(user)
    return steps


@cache
def _sources_of(path: Path) -> frozenset[Path]:
    """Return a test file and the files of the tests' own that it imports, conftest.py too."""
    folders = [path.parent, *(one for one in path.parents if one.name == "test")]
    found, waiting = {path}, [path, *(one / "conftest.py" for one in folders)]
    while waiting:
        here = waiting.pop()
        if not here.exists():
            continue
        found.add(here)
        names = {
            node.module or ""
            for node in ast.walk(ast.parse(here.read_text(encoding="utf-8")))
            if isinstance(node, ast.ImportFrom)
        }
        beside = [folder / f"{name}.py" for folder in folders for name in names]
        waiting += [one for one in beside if one not in found]
    return frozenset(found)


@cache
def _modules_named_in(path: Path) -> frozenset[str]:
    """Return the modules that a source imports, or names in a text."""
    text = path.read_text(encoding="utf-8")
    named = set(re.findall(r"\bq2q_\w+(?:\.\w+)*", text))
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("q2q_"):
            named |= {f"{node.module}.{one.name}" for one in node.names}
    return frozenset(name for name in named if name in _graph().modules)
