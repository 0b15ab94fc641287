"""Change the safety code a little, in every place in turn, and count which changes its tests notice.

    python test/mutation.py [--share 0.5]

Each mutant runs in a fork of one warm process. A mutant is killed when a test fails. Mutations: comparisons,
and/or, arithmetic, numbers, `not`, and returned values; not the bounds that parameters are declared with.
"""

import argparse
import ast
import os
import sys
from collections.abc import Iterator
from copy import deepcopy
from importlib import import_module
from pathlib import Path
from random import Random
from types import ModuleType

import pytest

ROOT = Path(__file__).parents[1]
MODULES = ("q2q_control.fallback", "q2q_control.transit", "q2q_control.guard", "q2q_control.tick_watch")
"""In the order of their imports."""
TESTS = [str(ROOT / "src/q2q_control/test" / name) for name in ("test_guard.py", "test_fallback.py")]
SWAPS: dict[type[ast.AST], type[ast.AST]] = {
    ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.And: ast.Or, ast.Or: ast.And, ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div, ast.Div: ast.Mult, ast.BitOr: ast.BitAnd, ast.BitAnd: ast.BitOr,
}  # fmt: skip


def mutants(tree: ast.Module) -> Iterator[tuple[str, ast.Module]]:
    """Yield every mutant of a module with the place of its change."""
    declared = {
        id(inner)
        for call in ast.walk(tree)
        if isinstance(call, ast.Call) and isinstance(call.func, ast.Name) and call.func.id == "tunable"
        for word in call.keywords
        for inner in ast.walk(word)
    }
    for index, node in enumerate(ast.walk(tree)):
        if id(node) in declared:
            continue
        copy = deepcopy(tree)
        here = list(ast.walk(copy))[index]
        if _mutate(here, node):
            yield f"line {getattr(node, 'lineno', 0)} {type(node).__name__}", ast.fix_missing_locations(copy)


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


def killed(module: ModuleType, tree: ast.Module) -> bool:
    """Return whether the tests notice a mutant, in a process of its own."""
    child = os.fork()
    if child:
        return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) != 0
    with Path(os.devnull).open("w") as nothing:
        os.dup2(nothing.fileno(), 1)
        os.dup2(nothing.fileno(), 2)
    try:
        exec(compile(tree, str(module.__file__), "exec"), module.__dict__)  # noqa: S102  our own source
        for name in MODULES[MODULES.index(module.__name__) + 1 :]:
            later = import_module(name)
            exec(compile(Path(str(later.__file__)).read_text(), str(later.__file__), "exec"), later.__dict__)  # noqa: S102
        for name in [name for name, one in sys.modules.items() if getattr(one, "__file__", None) in TESTS]:
            del sys.modules[name]  # they hold what the modules were
        status = pytest.main(["-x", "-q", "-p", "no:cacheprovider", "-k", "not mpc", *TESTS])
    except BaseException:  # noqa: BLE001  a mutant that cannot even be loaded is noticed
        status = 1
    os._exit(int(status))


def main() -> int:
    """Print what survives, and the share that is killed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--share", type=float, default=1.0, help="share of the mutants to try, drawn at random"
    )
    asked = parser.parse_args()
    pytest.main(["-q", "-p", "no:cacheprovider", "-k", "not mpc", *TESTS])  # loads what is compiled
    tried = dead = 0
    draw = Random(0)
    for name in MODULES:
        module = import_module(name)
        for place, tree in mutants(ast.parse(Path(str(module.__file__)).read_text())):
            if draw.random() > asked.share:
                continue
            tried += 1
            noticed = killed(module, tree)
            dead += noticed
            if not noticed:
                print(f"survives: {name} {place}", flush=True)
            print(f"{dead} of {tried}", file=sys.stderr, flush=True)
    print(f"{dead} of {tried} mutants killed: {100.0 * dead / max(tried, 1):.0f} %")
    return 0


if __name__ == "__main__":
    sys.exit(main())
