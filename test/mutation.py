"""Mutation scores of the safety code: change it in one place at a time, and count what its tests notice.

    python test/mutation.py [--jobs 2] [--share 0.5 [--after 0.5]] [--only q2q_control.failsafe.guard]

Loops run uncompiled where they are mutated. The tests of some modules are collected, and run once while it is
noted which functions each calls; what runs compiled is not seen, so that all tests are taken to call it. A
mutant then is a fork of this warm process: the changed function gets its new code in place, and the tests
that call it run, the quickest first, until one fails, which kills the mutant. So does more than PATIENCE
times the processor time that these tests took before. `mutants` has the mutations, `mutated_modules` what is
mutated.
"""

import argparse
import ast
import functools
import gc
import os
import resource
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from random import Random
from time import process_time
from types import CodeType, FrameType, FunctionType, ModuleType

import pytest
from _pytest.runner import runtestprotocol
from hypothesis import Phase, settings
from mutants import Mutant, mutants
from mutated_modules import MUTATED, MutatedModules

ROOT = Path(__file__).parents[1]
PATIENCE, LEAST_S = 5.0, 10
"""A mutant is taken to hang after so many times the processor time of its tests, and so many seconds [s]."""
Place = tuple[str, int]
"""File and first line of a function."""


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
            _rebind(name, old, getattr(new, "py_func", new))  # what was compiled is not compiled again


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
    """The tests of some modules as a pytest plugin, and what they do to mutants."""

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
    failed = [one for one in MUTATED if not _in_a_process_of_its_own(one, asked)]
    return int(bool(failed))


def _in_a_process_of_its_own(mutated: MutatedModules, asked: argparse.Namespace) -> bool:
    """Try the mutants of some modules and print their scores; return whether the tests pass without any."""
    modules = [name for name in mutated.modules if name.startswith(asked.only)]
    if not modules:
        return True
    child = os.fork()
    if child:
        return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
    os.environ["NUMBA_DISABLE_JIT"] = "0" if mutated.compiled else "1"  # before numba is loaded
    trial = Trial(modules, asked)
    tests = [str(ROOT / name) for name in mutated.tests]
    silent = ["-W", "ignore::RuntimeWarning"]  # of numbers that compiled loops divide without a word
    words = ["-q", *silent, "-p", "no:cacheprovider", "-p", "no:xdist", "-k", mutated.left_out, *tests]
    os._exit(int(pytest.main(words, plugins=[trial])))


if __name__ == "__main__":
    sys.exit(main())
