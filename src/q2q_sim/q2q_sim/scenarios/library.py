"""Loading of scenarios: shipped YAML files, `swarmN` for any N, and user files.

A user file is a scenario, waypoints alone, or a plan; missing keys have the defaults of a scenario.
"""

from collections.abc import Mapping
from pathlib import Path

from q2q_model.documents.plain_values import from_plain
from q2q_model.documents.yaml_text import load_yaml
from q2q_planner.offline.certificate.certified_file import load_plan
from q2q_sim.plant.disturbance import DisturbanceParams
from q2q_sim.scenarios.scenario import Scenario
from q2q_sim.scenarios.scenario_document import scenario_from_document
from q2q_sim.scenarios.scenario_files import FOLDER, PLAN, names, path_of, swarm_size
from q2q_sim.scenarios.swarm_scenario import swarm_scenario

__all__ = ["Scenario", "describe", "document", "load", "names", "replaced_by_air"]


def describe(name: str) -> str:
    """Return the one-line description of a scenario."""
    return load(name).description


def load(name_or_path: str) -> Scenario:
    """Return a scenario by its name, or from a YAML file or plan file.

    Raises:
        ValueError: unknown scenario (with the nearest name), or a value that is not allowed.
    """
    count = swarm_size(name_or_path)
    return swarm_scenario(count) if count is not None else _read(path_of(name_or_path))


def document(name: str) -> Mapping[str, object]:
    """Return the shipped scenario of a YAML file; raise ValueError if there is no such file."""
    return from_plain(dict[str, object], load_yaml(FOLDER / f"{name}.yaml"), name)


def replaced_by_air(name_or_path: str) -> list[str]:
    """Return one remark for each of wake and disturbance in a scenario's file that its air replaces."""
    if swarm_size(name_or_path) is not None or (path := path_of(name_or_path)).suffix == PLAN:
        return []
    scenario, given = _read(path), from_plain(dict[str, object], load_yaml(path), path.name)
    if not scenario.air:
        return []
    replaced = [] if scenario.wake == "none" else [f"wake: {scenario.wake}"]
    if "disturbance" in given and scenario.disturbance != DisturbanceParams():
        replaced.append("disturbance")
    return [f"{key} is replaced by air: {scenario.air}" for key in replaced]


def _read(path: Path) -> Scenario:
    parsed = {"plan": path.name} if path.suffix == PLAN else load_yaml(path)
    if parsed is None:
        raise ValueError(f"scenario file {path} is empty: write description, duration and vehicles")
    try:
        return scenario_from_document(path.stem, parsed, lambda named: load_plan(path.parent / named))
    except ValueError as error:
        raise ValueError(f"scenario {path.stem}: {error}") from error
