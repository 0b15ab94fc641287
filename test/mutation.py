"""Mutation scores of the safety code: change it in one place at a time, and count what its tests notice.

    python test/mutation.py [--jobs 2] [--share 0.5 [--after 0.5]] [--only q2q_control.failsafe.guard]

Loops run uncompiled where they are mutated. The tests of a room are collected, and run once while it is noted
which functions each calls; what runs compiled is not seen, so that all tests are taken to call it. A mutant
then is a fork of this warm process: the changed function gets its new code in place, and the tests that call
it run, the quickest first, until one fails, which kills the mutant. So does more than PATIENCE times the
processor time that these tests took before. Mutations: comparisons, and/or, arithmetic, numbers, `not`, and
returned values; not the bounds that parameters are declared with, nor whether a class is frozen.
"""

import argparse
import ast
import functools
import gc
import os
import resource
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from random import Random
from time import process_time
from types import CodeType, FrameType, FunctionType, ModuleType

import pytest
from _pytest.runner import runtestprotocol
from hypothesis import Phase, settings

ROOT = Path(__file__).parents[1]
PATIENCE, LEAST_S = 5.0, 10
"""A mutant is taken to hang after so many times the processor time of its tests, and so many seconds [s]."""


@dataclass(frozen=True, slots=True)
class Room:
    """Modules that are mutated, and the tests that must notice."""

    modules: tuple[str, ...]
    tests: tuple[str, ...]
    left_out: str = ""
    """Which tests are not run, in pytest's words: slow ones that others back up."""
    compiled: bool = False
    """Loops of other modules run compiled; the mutated ones call them, and are not called by them."""


ROOMS = (
    Room(
        tuple(
            f"q2q_control.failsafe.{name}"
            for name in (
                "ladder",
                "stamp_delay",
                "blind_flight.dead_reckoned_braking",
                "evasion.climb_back",
                "evasion.descent_evasion",
                "guard",
                "tick_watch",
            )
        ),
        tuple(
            f"src/q2q_control/test/test_{name}.py"
            for name in (
                "guard",
                "tick_watch",
                "stamp_delay",
                "ladder",
                "dead_reckoned_braking",
                "climb_back",
                "descent_evasion",
            )
        ),
        "not mpc",
    ),
    Room(
        (
            "q2q_model.estimation.clock_resets",
            *(
                f"q2q_model.estimation.{name}"
                for name in (
                    "reacquisition",
                    "marker_swaps",
                    "position_gates",
                    "attitudes",
                    "positions",
                )
            ),
        ),
        tuple(
            f"src/q2q_model/test/test_{name}.py"
            for name in (
                "clock_resets",
                "tracking_gates",
                "position_gates",
                "position_tracks",
                "attitude_tracks",
                "mocap_filter",
                "mocap_filter_lies",
            )
        ),
    ),
    Room(
        tuple(
            f"q2q_planner.online.safe.{name}"
            for name in (
                "safe_replanner",
                "last_known_states",
                "committed_motion",
                "decision",
                "tracking_uncertainty",
                "found_again",
                "traffic",
                "wanted_motion",
            )
        ),
        tuple(
            f"src/q2q_planner/test/test_{name}.py"
            for name in (
                "committed_motion",
                "traffic",
                "safe_tick",
                "safe_replanner",
                "steady_replanner",
                "encounters",
            )
        ),
        compiled=True,
    ),
    Room(
        ("q2q_planner.online.safe.stopping.jerk_limited",),
        ("src/q2q_planner/test/test_jerk_limited.py",),
        "not compiled_and_plain",
    ),
)
DECLARING = {"tunable", "dataclass"}
"""Calls whose words say what something is, not what it does."""
SWAPS: dict[type[ast.AST], type[ast.AST]] = {
    ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.And: ast.Or, ast.Or: ast.And, ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div, ast.Div: ast.Mult, ast.BitOr: ast.BitAnd, ast.BitAnd: ast.BitOr,
}  # fmt: skip
MUTABLE = (ast.Compare, ast.BoolOp, ast.BinOp, ast.Constant, ast.Return, ast.UnaryOp)
Place = tuple[str, int]
"""File and first line of a function."""


@dataclass(frozen=True, slots=True)
class Mutant:
    """A module changed in one place."""

    change: str
    function: int
    """First line of the function that is changed; 0 outside of all."""
    tree: ast.Module


def mutants(tree: ast.Module) -> Iterator[Mutant]:
    """Yield every mutant of a module; its tree is as it was again once the next one is asked for."""
    calls = [
        call for call in ast.walk(tree) if isinstance(call, ast.Call) and isinstance(call.func, ast.Name)
    ]
    declared = {
        id(inner)
        for call in calls
        if isinstance(call.func, ast.Name) and call.func.id in DECLARING
        for word in call.keywords
        for inner in ast.walk(word)
    }
    functions = _functions_of(tree)
    for node in [one for one in ast.walk(tree) if isinstance(one, MUTABLE) and id(one) not in declared]:
        kept = {name: list(part) if isinstance(part, list) else part for name, part in vars(node).items()}
        lines = ast.unparse(node)
        if _mutate(node):
            change = f"line {node.lineno}: {lines} -> {ast.unparse(node)}"
            yield Mutant(change, functions.get(id(node), 0), ast.fix_missing_locations(tree))
        vars(node).update(kept)


def _functions_of(tree: ast.Module) -> dict[int, int]:
    """Return the first line of the innermost function around each node, by the node's id."""
    found = {}
    for node in ast.walk(tree):  # outer ones first
        if isinstance(node, ast.FunctionDef):
            first = min([node.lineno, *(one.lineno for one in node.decorator_list)])
            found.update({id(inner): first for part in node.body for inner in ast.walk(part)})
    return found


def _mutate(here: ast.AST) -> bool:
    """Change a node, if there is a way to; return whether there was."""
    if isinstance(here, ast.Compare) and type(here.ops[0]) in SWAPS:
        here.ops[0] = SWAPS[type(here.ops[0])]()  # type: ignore[assignment]
    elif isinstance(here, ast.BoolOp | ast.BinOp) and type(here.op) in SWAPS and _is_value(here):
        here.op = SWAPS[type(here.op)]()  # type: ignore[assignment]
    elif isinstance(here, ast.Constant) and isinstance(here.value, float | int) and here.value is not ...:
        here.value = not here.value if isinstance(here.value, bool) else here.value + 1
    elif isinstance(here, ast.Return) and here.value is not None and not isinstance(here.value, ast.Constant):
        here.value = ast.Constant(None)
    elif isinstance(here, ast.UnaryOp) and isinstance(here.op, ast.Not | ast.Invert):
        here.op = ast.UAdd()
    else:
        return False
    return True


def _is_value(node: ast.BoolOp | ast.BinOp) -> bool:
    """Return whether an operator computes: `A | None` in a type does not."""
    return not (isinstance(node, ast.BinOp) and isinstance(node.op, ast.BitOr) and "None" in ast.dump(node))


def transplant(module: ModuleType, tree: ast.Module) -> None:
    """Give a loaded module the code and the constants of a changed source, whoever holds its functions."""
    fresh = {"__name__": module.__name__, "__file__": module.__file__}
    exec(compile(tree, str(module.__file__), "exec"), fresh)  # noqa: S102  our own source
    for name, new in fresh.items():
        old = module.__dict__.get(name)
        if name.startswith("__") or getattr(old, "__module__", module.__name__) != module.__name__:
            continue
        if isinstance(old, type):
            for inner, value in vars(new).items():
                _take_code(vars(old).get(inner), value)
        elif hasattr(old, "py_func") or not _take_code(old, new):
            _rebind(name, old, getattr(new, "py_func", new))  # what was compiled is not compiled anew


def _take_code(old: object, new: object) -> bool:
    """Give a function the code of another; return whether it is one."""
    for attribute in ("fget", "__func__", "__wrapped__"):  # property, static or class method, wrapper
        old, new = getattr(old, attribute, old), getattr(new, attribute, new)
    if isinstance(old, FunctionType) and isinstance(new, FunctionType):
        old.__code__, old.__defaults__ = new.__code__, new.__defaults__
        old.__kwdefaults__ = new.__kwdefaults__
        return True
    return False


def _rebind(name: str, old: object, new: object) -> None:
    """Put a constant in the place of another wherever it was imported."""
    for holder in list(sys.modules.values()):
        if vars(holder).get(name) is old:
            setattr(holder, name, new)


def forget_caches() -> None:
    """Empty every functools.cache: what they hold was made by other code."""
    for one in gc.get_objects():
        if isinstance(one, functools._lru_cache_wrapper):
            one.cache_clear()


@dataclass(slots=True)
class Trial:
    """The tests of a room as a pytest plugin, and what they do to mutants."""

    modules: Sequence[str]
    asked: argparse.Namespace
    draw: Random = field(default_factory=lambda: Random(0))
    calls: dict[str, set[Place]] = field(default_factory=dict)
    """Functions that each test calls."""
    took: dict[str, float] = field(default_factory=dict)
    """Processor time of each test [s]."""

    def pytest_configure(self) -> None:
        """Let hypothesis draw the same examples for every mutant."""
        generate = [Phase.explicit, Phase.generate]
        settings.register_profile(
            "mutation", deadline=None, derandomize=True, database=None, phases=generate, max_examples=20
        )
        settings.load_profile("mutation")

    def pytest_runtestloop(self, session: pytest.Session) -> bool | None:
        """Run every test once, then those of each mutant; leave what cannot be collected to pytest."""
        if session.testsfailed:
            return None
        for item in session.items:
            self._learn(item)
        for name in self.modules:
            self._try_module(sys.modules[name], session.items)
        return True

    def _learn(self, item: pytest.Item) -> None:
        found: set[Place] = set()

        def note(frame: FrameType, _: str, __: object) -> None:
            code: CodeType = frame.f_code
            found.add((code.co_filename, code.co_firstlineno))

        forget_caches()
        began = process_time()
        sys.settrace(note)
        try:
            reports = runtestprotocol(item, log=False, nextitem=None)
        finally:
            sys.settrace(None)
        if any(report.failed for report in reports):
            raise pytest.UsageError(f"{item.nodeid} fails without any mutation")
        self.calls[item.nodeid], self.took[item.nodeid] = found, process_time() - began

    def _try_module(self, module: ModuleType, items: Sequence[pytest.Item]) -> None:
        file, first, last = str(module.__file__), self.asked.after, self.asked.after + self.asked.share
        quickest = sorted(items, key=lambda item: self.took[item.nodeid])
        running: dict[int, Mutant] = {}
        tried = killed = 0
        chosen = (
            one for one in mutants(ast.parse(Path(file).read_text())) if first <= self.draw.random() < last
        )

        def wait() -> int:
            pid, status = os.wait()
            mutant = running.pop(pid)
            if status == 0:
                print(f"survives: {module.__name__} {mutant.change}", flush=True)
            return int(status != 0)

        for mutant in chosen:
            if len(running) >= self.asked.jobs:
                killed += wait()
            tests = [item for item in quickest if self._reaches(item, file, mutant)] or quickest
            child = _forked(lambda mutant=mutant, tests=tests: self._survives(module, mutant, tests))
            running[child] = mutant
            tried += 1
        while running:
            killed += wait()
        share = 100.0 * killed / max(tried, 1)
        print(f"| {module.__name__} | {killed} of {tried}, {share:.0f} % |", flush=True)

    def _reaches(self, item: pytest.Item, file: str, mutant: Mutant) -> bool:
        return not mutant.function or (file, mutant.function) in self.calls[item.nodeid]

    def _survives(self, module: ModuleType, mutant: Mutant, tests: Sequence[pytest.Item]) -> bool:
        forget_caches()
        limit = LEAST_S + int(PATIENCE * sum(self.took[item.nodeid] for item in tests))
        resource.setrlimit(resource.RLIMIT_CPU, (limit, limit))  # SIGKILL: noticed
        transplant(module, mutant.tree)
        for test in {item.getparent(pytest.Module).obj for item in tests}:
            test.__spec__.loader.exec_module(test)  # its constants, made by the changed code
        for item in tests:
            if any(report.failed for report in runtestprotocol(item, log=False, nextitem=None)):
                return False
        return True


def _forked(survives: Callable[[], bool]) -> int:
    """Return the process that ends with 0 where a mutant survives."""
    child = os.fork()
    if child:
        return child
    status = 1  # a mutant that cannot even be loaded is noticed
    try:
        with Path(os.devnull).open("w") as nothing:
            os.dup2(nothing.fileno(), 1)
            os.dup2(nothing.fileno(), 2)
        status = 0 if survives() else 1
    finally:
        os._exit(status)


def main() -> int:
    """Print what survives, and the share that is killed."""
    plain = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=plain)
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="mutants tried at a time")
    parser.add_argument(
        "--share", type=float, default=1.0, help="share of the mutants to try, drawn at random"
    )
    parser.add_argument(
        "--after", type=float, default=0.0, help="share of the mutants to leave out before: a run in pieces"
    )
    parser.add_argument("--only", default="", help="modules whose names begin so")
    asked = parser.parse_args()
    failed = [room for room in ROOMS if not _in_a_process_of_its_own(room, asked)]
    return int(bool(failed))


def _in_a_process_of_its_own(room: Room, asked: argparse.Namespace) -> bool:
    """Try a room's mutants and print its scores; return whether its tests pass without any."""
    modules = [name for name in room.modules if name.startswith(asked.only)]
    if not modules:
        return True
    child = os.fork()
    if child:
        return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
    os.environ["NUMBA_DISABLE_JIT"] = "0" if room.compiled else "1"  # before numba is loaded
    trial = Trial(modules, asked)
    tests = [str(ROOT / name) for name in room.tests]
    silent = ["-W", "ignore::RuntimeWarning"]  # of numbers that compiled loops divide without a word
    words = ["-q", *silent, "-p", "no:cacheprovider", "-p", "no:xdist", "-k", room.left_out, *tests]
    os._exit(int(pytest.main(words, plugins=[trial])))


if __name__ == "__main__":
    sys.exit(main())
