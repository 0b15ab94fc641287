"""YAML documents as plain values; an error is one line with the place in the file.

A duplicate key, of which YAML would silently keep the last, is an error. Numbers are those of JSON, also with
a plus sign or without a digit on one side of the point, and 0x1F; what YAML 1.1 and 1.2 read differently, as
010, 0o10, 1:30 and 1_0, is text. Other values are those of YAML 1.1, as PyYAML reads them: on, yes and off.
"""

import re
from itertools import chain
from pathlib import Path

import yaml

from q2q_model.documents.read_text import read_text

MOST_VALUES = 1_000_000
"""Most values of a document, those of aliases counted at each use: 1000 vehicles of 100 waypoints."""


def load_yaml(path: Path) -> object:
    """Return the content of a YAML file.

    Raises:
        ValueError: naming the file, and the line or why it cannot be read.
    """
    try:
        return parse_yaml(read_text(path))
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error


def parse_yaml(text: str) -> object:
    """Return the content of a YAML text; raise ValueError naming the line."""
    try:
        return yaml.load(text, _Loader)  # noqa: S506  a SafeLoader
    except yaml.MarkedYAMLError as error:
        line = "" if error.problem_mark is None else f"line {error.problem_mark.line + 1}: "
        raise ValueError(f"is not valid YAML: {line}{_one_line(error.problem)}") from error
    except RecursionError as error:
        raise ValueError("is nested too deeply") from error
    except (yaml.YAMLError, ValueError, LookupError, AttributeError) as error:  # LookupError: of `!!bool x`
        raise ValueError(f"is not valid YAML: {_one_line(error)}") from error


def _one_line(problem: object) -> str:
    return " ".join(str(problem).split())


class _Loader(yaml.SafeLoader):
    """Loader of plain values that refuses duplicate keys, and aliases that stand for endless values."""

    def get_single_node(self) -> yaml.Node | None:
        """Return the document's node; raise ComposerError if it has more than MOST_VALUES values."""
        node = super().get_single_node()
        if node is not None and _values(node, {}) > MOST_VALUES:
            problem = f"more than {MOST_VALUES} values: write fewer values or aliases"
            raise yaml.composer.ComposerError(problem=problem, problem_mark=node.start_mark)
        return node

    def compose_mapping_node(self, anchor: str | None) -> yaml.MappingNode:  # type: ignore[override]  # as PyYAML
        """Return the next mapping; raise ComposerError for a duplicate key."""
        node = super().compose_mapping_node(anchor)  # type: ignore[arg-type]
        known = set()
        for key, _ in node.value:
            if isinstance(key, yaml.ScalarNode):
                if key.value in known:
                    problem = f"duplicate key {key.value!r}: give each key once"
                    raise yaml.composer.ComposerError(problem=problem, problem_mark=key.start_mark)
                known.add(key.value)
        return node


def _values(node: yaml.Node, counted: dict[int, int]) -> int:
    """Return how many values a node stands for; `counted` are those of nodes by their identity.

    An alias of a node around it counts without end.
    """
    if isinstance(node, yaml.ScalarNode):
        return 1
    if id(node) not in counted:
        counted[id(node)] = MOST_VALUES + 1
        inner = chain.from_iterable(node.value) if isinstance(node, yaml.MappingNode) else node.value
        counted[id(node)] = 1 + sum(_values(one, counted) for one in inner)
    return counted[id(node)]


_INT, _FLOAT = "tag:yaml.org,2002:int", "tag:yaml.org,2002:float"

_Loader.yaml_implicit_resolvers = {
    first: [(tag, pattern) for tag, pattern in resolvers if tag not in {_INT, _FLOAT}]
    for first, resolvers in yaml.SafeLoader.yaml_implicit_resolvers.items()
}
_Loader.add_implicit_resolver(_INT, re.compile(r"[-+]?(0|[1-9][0-9]*)$|0x[0-9a-fA-F]+$"), [*"-+0123456789"])
_Loader.add_implicit_resolver(
    _FLOAT,
    re.compile(
        r"[-+]?(\.[0-9]+|[0-9]+\.[0-9]*)([eE][-+]?[0-9]+)?$|[-+]?[0-9]+[eE][-+]?[0-9]+$"
        r"|[-+]?\.(inf|Inf|INF)$|\.(nan|NaN|NAN)$"
    ),
    [*"-+.0123456789"],
)
