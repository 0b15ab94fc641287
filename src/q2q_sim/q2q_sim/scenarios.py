"""Find scenarios: the shipped YAML files, `swarmN` for any N, and files of the user's own."""

import re
from collections.abc import Mapping
from difflib import get_close_matches
from pathlib import Path

import yaml

from q2q_sim.scenario import Scenario, scenario_from_document
from q2q_sim.swarm_scenario import MOST, swarm_scenario

__all__ = ["Scenario", "describe", "document", "load", "names"]

FOLDER = Path(__file__).parent / "scenarios"
"""Where the shipped scenarios lie."""
SWARM = re.compile(r"swarm([0-9]+)")
EXAMPLE_SWARM = "swarm10"
"""Stands for all `swarmN` in the list."""


def names() -> list[str]:
    """Return the names that `load` knows; `swarm10` stands for any `swarmN`."""
    return [*sorted(path.stem for path in FOLDER.glob("*.yaml")), EXAMPLE_SWARM]


def describe(name: str) -> str:
    """Return one line on a scenario."""
    return load(name).description


def load(name_or_path: str) -> Scenario:
    """Return a scenario by its name, or from a YAML file.

    Raises:
        ValueError: no such scenario (with the nearest right name), or a value that is not allowed.
    """
    swarm = SWARM.fullmatch(name_or_path)
    if swarm:
        return swarm_scenario(int(swarm[1]))
    shipped = FOLDER / f"{name_or_path}.yaml"
    own = Path(name_or_path)
    if own.suffix in {".yaml", ".yml"}:
        return _read(own)
    if own.name == name_or_path and shipped.is_file():
        return _read(shipped)
    near = get_close_matches(name_or_path, names(), n=1)
    hint = f"did you mean {near[0]}?" if near else f"known are {', '.join(names())}"
    raise ValueError(
        f"unknown scenario {name_or_path!r}; {hint} (swarmN: 1 to {MOST} vehicles; or a .yaml file)"
    )


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
