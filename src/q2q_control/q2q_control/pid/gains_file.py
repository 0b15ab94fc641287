"""Files of gains of the PID: ROS 2 parameter files, shipped ones by name.

| name | gains |
|---|---|
| tuned | for a Crazyflie in a real room, with integrals |
| learned | the paper's, the defaults of the node: 1 % of wrong thrust is 12 cm of height |
| firmware | the firmware's own PID |
| mellinger | the firmware's Mellinger controller |
"""

from collections.abc import Mapping
from pathlib import Path

from q2q_control.pid.pid import PidParams
from q2q_model.documents.plain_values import from_plain
from q2q_model.documents.yaml_text import load_yaml
from q2q_model.files.shipped_folder import shipped_folder

PREFIX = "pid_"
TUNED = "tuned"
PARAMETERS = "ros__parameters"


def load_gains(asked: str) -> PidParams:
    """Return the parameters of the PID in a file, given by the name of a shipped one or by its path.

    Raises:
        ValueError: there is no such file, or it is no parameter file of the PID.
    """
    path = _path(asked)
    document = load_yaml(path)
    sections = list(document.values()) if isinstance(document, Mapping) else []
    if len(sections) != 1 or not isinstance(sections[0], Mapping) or PARAMETERS not in sections[0]:
        raise ValueError(
            f"{path}: one node (or /**) with {PARAMETERS} is expected, as in {PREFIX}{TUNED}.yaml"
        )
    return from_plain(PidParams, sections[0][PARAMETERS], str(path))


def _path(asked: str) -> Path:
    folder = shipped_folder(Path(__file__).parents[1])
    named = folder / f"{PREFIX}{asked}.yaml"
    if Path(asked).name == asked and named.is_file():
        return named
    if Path(asked).is_file():
        return Path(asked)
    known = ", ".join(sorted(path.stem.removeprefix(PREFIX) for path in folder.glob(f"{PREFIX}*.yaml")))
    raise ValueError(f"no gains {asked!r}: give one of {known}, or the path of a parameter file of the PID")
