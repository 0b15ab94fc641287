"""Files of scenarios by name, without reading them: shipped ones, `swarmN`, and user files."""

import re
from pathlib import Path

from q2q_model.nearest_name import name_hint
from q2q_sim.scenarios.scenario_limits import MOST_VEHICLES

FOLDER = Path(__file__).parent
"""Folder of the shipped scenarios."""
SWARM = re.compile(r"swarm([0-9]+)")
EXAMPLE_SWARM = "swarm10"
"""Represents all `swarmN` in the list."""
PLAN = ".json"
"""Ending of a plan file."""
OWN = (".yaml", ".yml", PLAN)
"""Endings of user files: a scenario or waypoints, or a plan."""


def names() -> list[str]:
    """Return the names of scenarios; `swarm10` represents any `swarmN`."""
    return [*sorted(path.stem for path in FOLDER.glob("*.yaml")), EXAMPLE_SWARM]


def check(name_or_path: str) -> None:
    """Raise ValueError if there is no such scenario."""
    count = swarm_size(name_or_path)
    if count is None:
        path_of(name_or_path)


def swarm_size(name: str) -> int | None:
    """Return the N of `swarmN`, None for another name; raise ValueError if N is 0 or too large."""
    swarm = SWARM.fullmatch(name)
    count = int(swarm[1]) if swarm else None
    if count is not None and not 1 <= count <= MOST_VEHICLES:
        raise ValueError(f"swarm{count}; must have 1 to {MOST_VEHICLES} vehicles")
    return count


def path_of(name_or_path: str) -> Path:
    """Return the file of a scenario.

    Raises:
        ValueError: unknown scenario (with the nearest name), or no such file.
    """
    if not name_or_path:
        raise ValueError("the scenario is empty: give its name, e.g. table6, or its file")
    shipped, own = FOLDER / f"{name_or_path}.yaml", Path(name_or_path)
    if own.suffix in OWN:
        if not own.exists():
            raise ValueError(f"scenario file {own}: cannot be read (No such file or directory)")
        return own
    if own.name == name_or_path and shipped.is_file():
        return shipped
    if own.is_dir():
        raise ValueError(f"{own} is a folder: give a file in it (.yaml or .json), or the name of a scenario")
    raise ValueError(
        f"unknown scenario {name_or_path!r}; {name_hint(name_or_path, names())} "
        f"(swarmN: 1 to {MOST_VEHICLES} vehicles; "
        "or a file: .yaml of a scenario or waypoints, .json of a plan)"
    )
