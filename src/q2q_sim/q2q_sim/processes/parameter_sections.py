"""Sections of parameter files: ROS ignores one whose name no node has."""

from collections.abc import Collection, Mapping, Sequence
from difflib import get_close_matches
from itertools import pairwise
from pathlib import Path

from q2q_model.documents.yaml_text import load_yaml

PARAMETERS = "ros__parameters"
"""Key of a node's parameters."""


def misspelt_sections(
    arguments: Sequence[str], running: Collection[str], known: Collection[str]
) -> list[str]:
    """Return notes of sections in a process's parameter files that seem to be meant for one of its nodes.

    Args:
        arguments: command line of the process.
        running: names of its nodes.
        known: names of nodes in other processes, whose sections the files may hold, too.

    Raises:
        ValueError: a file cannot be read, or has a key twice.
    """
    words = pairwise(arguments)
    files = [Path(after) for word, after in words if word == "--params-file"]
    return [
        f"{file}: no node reads the section {name}; did you mean {near[0]}?"
        for file in files
        for name in sorted(section_nodes(load_yaml(file)) - {*running, *known})
        if (near := get_close_matches(name, running, n=1))
    ]


def section_nodes(document: object) -> set[str]:
    """Return the node names of a parameter file's sections, without their namespaces."""
    found: set[str] = set()
    if isinstance(document, Mapping) and PARAMETERS not in document:
        for key, value in document.items():
            if isinstance(value, Mapping) and PARAMETERS in value:
                found.add(str(key).rpartition("/")[2])
            found |= section_nodes(value)
    return found
