"""Load scenarios: the shipped YAML files, `swarmN` for any N, and files of the user's own."""

from collections.abc import Mapping
from pathlib import Path

import yaml

from q2q_sim.scenario import Scenario, scenario_from_document
from q2q_sim.scenario_files import FOLDER, names, path_of, swarm_size
from q2q_sim.swarm_scenario import swarm_scenario

__all__ = ["Scenario", "describe", "document", "load", "names"]


def describe(name: str) -> str:
    """Return one line on a scenario."""
    return load(name).description


def load(name_or_path: str) -> Scenario:
    """Return a scenario by its name, or from a YAML file.

    Raises:
        ValueError: no such scenario (with the nearest right name), or a value that is not allowed.
    """
    count = swarm_size(name_or_path)
    return swarm_scenario(count) if count is not None else _read(path_of(name_or_path))


def document(name: str) -> Mapping[str, object]:
    """Return a shipped scenario as its YAML says it; raise ValueError where there is no such file."""
    return _parsed(FOLDER / f"{name}.yaml")


def _read(path: Path) -> Scenario:
    parsed = _parsed(path)
    try:
        return scenario_from_document(path.stem, parsed)
    except ValueError as error:
        raise ValueError(f"scenario {path.stem}: {error}") from error


def _parsed(path: Path) -> Mapping[str, object]:
    try:
        found: Mapping[str, object] = yaml.safe_load(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ValueError(f"scenario file {path}: cannot be read ({error.strerror})") from error
    except (yaml.YAMLError, UnicodeDecodeError, RecursionError) as error:
        raise ValueError(f"scenario file {path}: is no YAML ({error})") from error
    return found
