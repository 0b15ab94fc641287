"""Mutants of a module: its syntax tree changed in one place at a time.

Mutations: comparisons, and/or, arithmetic, numbers, `not`, and returned values; not the bounds that
parameters are declared with, nor whether a class is frozen.
"""

import ast
from collections.abc import Iterator
from dataclasses import dataclass

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
