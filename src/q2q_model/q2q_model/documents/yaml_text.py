"""YAML documents as plain values; an error is one line with the place in the file.

A duplicate key, of which YAML would silently keep the last, is an error. 1e-3 is a number, as in YAML 1.2; in
YAML 1.1, which PyYAML reads, it is text.
"""

import re
from pathlib import Path

import yaml

from q2q_model.documents.read_text import read_text


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
    """Loader of plain values that refuses duplicate keys."""

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


_Loader.add_implicit_resolver(
    "tag:yaml.org,2002:float", re.compile(r"[-+]?[0-9]+(\.[0-9]*)?[eE][-+]?[0-9]+$"), [*"-+0123456789"]
)
