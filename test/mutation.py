"""Change the safety code a little, in every place in turn, and count which changes its tests notice.

    python test/mutation.py [--share 0.5] [--only q2q_control.guard]

Each mutant runs in a fork of one warm process, against the tests of its room alone, slow ones left out: a
second or a few each. Loops run uncompiled, so that a mutant is not compiled anew. A mutant is killed when a
test fails. Mutations: comparisons, and/or, arithmetic, numbers, `not`, and returned values; not the bounds
that parameters are declared with, nor whether a class is frozen.
"""

import argparse
import ast
import os
import signal
import sys
from collections.abc import Iterator
from copy import deepcopy
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from random import Random
from types import ModuleType

import pytest

os.environ["NUMBA_DISABLE_JIT"] = "1"  # before numba is loaded

ROOT = Path(__file__).parents[1]
STUCK_S = 180
"""A mutant that takes longer hangs, and that is noticed [s]."""


@dataclass(frozen=True, slots=True)
class Room:
    """Hold modules that are mutated together with the tests that must notice."""

    modules: tuple[str, ...]
    """In the order of their imports."""
    users: tuple[str, ...]
    """Modules loaded anew with them, not mutated."""
    tests: tuple[str, ...]
    left_out: str
    """Which tests are not run, in pytest's words: slow ones that others back up."""


ROOMS = (
    Room(
        tuple(
            f"q2q_control.{name}"
            for name in ("fallback", "transit", "blind_braking", "making_way", "guard", "tick_watch")
        ),
        (),
        tuple(
            f"src/q2q_control/test/test_{name}.py"
            for name in ("guard", "fallback", "blind_braking", "making_way")
        ),
        "not mpc",
    ),
    Room(
        (
            "q2q_model.old_stamps",
            *(
                f"q2q_model.tracking.{name}"
                for name in ("rivals", "swaps", "glide", "absences", "attitudes", "positions")
            ),
        ),
        ("q2q_model.mocap_filter",),
        tuple(
            f"src/q2q_model/test/test_{name}.py"
            for name in ("old_stamps", "absences", "tracking_gates", "mocap_filter", "mocap_filter_lies")
        ),
        "not no_gate and not no_numbers",
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


def mutants(tree: ast.Module) -> Iterator[tuple[str, ast.Module]]:
    """Yield every mutant of a module with the place of its change."""
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
    for index, node in enumerate(ast.walk(tree)):
        if id(node) in declared:
            continue
        copy = deepcopy(tree)
        here = list(ast.walk(copy))[index]
        if _mutate(here, node):
            made = ast.fix_missing_locations(copy)
            yield f"line {getattr(node, 'lineno', 0)}: {ast.unparse(node)} -> {ast.unparse(here)}", made


def _mutate(here: ast.AST, node: ast.AST) -> bool:
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
    return ast.dump(here) != ast.dump(node)


def _is_value(node: ast.BoolOp | ast.BinOp) -> bool:
    """Return whether an operator computes: `A | None` in a type does not."""
    return not (isinstance(node, ast.BinOp) and isinstance(node.op, ast.BitOr) and "None" in ast.dump(node))


def killed(room: Room, module: ModuleType, tree: ast.Module) -> bool:
    """Return whether the tests notice a mutant, in a process of its own."""
    child = os.fork()
    if child:
        return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) != 0
    with Path(os.devnull).open("w") as nothing:
        os.dup2(nothing.fileno(), 1)
        os.dup2(nothing.fileno(), 2)
    signal.alarm(STUCK_S)
    try:
        load(module, tree)
        chain = room.modules + room.users
        for name in chain[chain.index(module.__name__) + 1 :]:
            later = import_module(name)
            load(later, source_of(later))
        tests = {str(ROOT / name) for name in room.tests}
        for name in [name for name, one in sys.modules.items() if getattr(one, "__file__", None) in tests]:
            del sys.modules[name]  # they hold what the modules were
        status = run_tests(room)
    except BaseException:  # noqa: BLE001  a mutant that cannot even be loaded is noticed
        status = 1
    os._exit(status)


def source_of(module: ModuleType) -> ast.Module:
    """Return the source of a module as it stands."""
    return ast.parse(Path(str(module.__file__)).read_text())


def load(module: ModuleType, tree: ast.Module) -> None:
    """Run a source in place of a module's own."""
    exec(compile(tree, str(module.__file__), "exec"), module.__dict__)  # noqa: S102  our own source


def run_tests(room: Room) -> int:
    """Return pytest's verdict on a room."""
    tests = [str(ROOT / name) for name in room.tests]
    return int(pytest.main(["-x", "-q", "-p", "no:cacheprovider", "-k", room.left_out, *tests]))


def main() -> int:
    """Print what survives, and the share that is killed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--share", type=float, default=1.0, help="share of the mutants to try, drawn at random"
    )
    parser.add_argument("--only", default="", help="modules whose names begin so")
    asked = parser.parse_args()
    tried = dead = 0
    draw = Random(0)
    for room in ROOMS:
        chosen = [name for name in room.modules if name.startswith(asked.only)]
        if chosen and run_tests(room) != 0:  # loads what is needed, too
            raise SystemExit("the tests fail without any mutation")
        for name in chosen:
            module = import_module(name)
            before = (dead, tried)
            for place, tree in mutants(source_of(module)):
                if draw.random() > asked.share:
                    continue
                tried += 1
                noticed = killed(room, module, tree)
                dead += noticed
                if not noticed:
                    print(f"survives: {name} {place}", flush=True)
            print(f"{name}: {dead - before[0]} of {tried - before[1]}", flush=True)
    print(f"{dead} of {tried} mutants killed: {100.0 * dead / max(tried, 1):.0f} %")
    return 0


if __name__ == "__main__":
    sys.exit(main())
