"""Files of gains of the PID: ROS 2 parameter files, shipped ones by name.

| name | gains |
|---|---|
| tuned | for a Crazyflie in a real room, with integrals |
| learned | the paper's, the defaults of the node: 1 % of wrong thrust is 12 cm of height |
| firmware | the firmware's own PID |
| mellinger | the firmware's Mellinger controller |
"""

import math
from collections.abc import Mapping
from pathlib import Path

from q2q_control.pid.pid_params import PidParams
from q2q_model.documents.plain_values import from_plain
from q2q_model.documents.shipped_folder import shipped_folder, shipped_or_given
from q2q_model.documents.yaml_text import load_yaml
from q2q_model.vehicle.constants import GRAVITY

PREFIX = "pid_"
TUNED = "tuned"
SOFT_M = 0.05
"""Height by 1 % of wrong thrust from which is warned [m]: batteries and propellers differ by 5 to 10 %."""
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
        raise ValueError(f"{path}: must have one node (or /**) with {PARAMETERS}, as in {PREFIX}{TUNED}.yaml")
    return from_plain(PidParams, sections[0][PARAMETERS], str(path))


def soft_altitude(params: PidParams) -> str:
    """Return a warning of gains by which a small error of thrust moves vehicles far; empty if they do not."""
    off = 0.01 * GRAVITY / params.k_p_z if params.k_p_z > 0.0 else math.inf
    if params.k_i_z > 0.0 or off <= SOFT_M:
        return ""
    gains = f"k_p_z = {params.k_p_z:g}, k_i_z = {params.k_i_z:g}"
    return f"{gains}: a thrust error of 1 % is {off:.2f} m of height; real vehicles use {PREFIX}{TUNED}.yaml"


def _path(asked: str) -> Path:
    folder = shipped_folder(Path(__file__).parents[1])
    if (found := shipped_or_given(asked, folder / f"{PREFIX}{asked}.yaml")) is not None:
        return found
    known = ", ".join(sorted(path.stem.removeprefix(PREFIX) for path in folder.glob(f"{PREFIX}*.yaml")))
    raise ValueError(f"no gains {asked!r}: give one of {known}, or the path of a parameter file of the PID")
