"""Topic maps: YAML files that assign the topics of a bag to vehicles and signals.

vehicles:                 # one topic per vehicle: PoseStamped, TransformStamped or Odometry
  cf1: /vicon/cf1/pose
  cf2: /cf2/odom
poses: /poses             # also or instead: NamedPoseArray, all vehicles in one message
rename: {cf231: cf1}      # name in `poses`: name of the vehicle
references:               # reference positions, messages as under `vehicles`; the last one received holds
  cf1: /cf1/cmd_position
signals:                  # also or instead: topics of q2q_msgs under other names
  mocap: /room/frames
stamps: header            # or receive, if headers have no stamps
tolerance_s: 0.005        # poses captured within this time form one frame
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import yaml

from q2q_model.bag.storage.fault import BagError

TOLERANCE_S = 0.005
"""Half a period of VICON at 100 Hz [s]."""
_MAPPINGS = ("vehicles", "rename", "references", "signals")
KEYS = ("vehicles", "poses", "rename", "references", "signals", "stamps", "tolerance_s")


@dataclass(frozen=True, slots=True)
class TopicMap:
    """Signals and the topics they are read from."""

    vehicles: Mapping[str, str] = field(default_factory=dict)
    """Vehicle -> topic of its poses."""
    poses: str = ""
    """Topic of named poses of all vehicles."""
    rename: Mapping[str, str] = field(default_factory=dict)
    """Name in `poses` -> vehicle."""
    references: Mapping[str, str] = field(default_factory=dict)
    """Vehicle -> topic of its reference positions."""
    signals: Mapping[str, str] = field(default_factory=dict)
    """Topic of q2q -> topic of the bag."""
    by_header: bool = True
    """Whether time is the stamp of the header, not of the recorder."""
    tolerance_s: float = TOLERANCE_S


def load_topic_map(path: Path | str) -> TopicMap:
    """Return the map in a YAML file; raise BagError for a key or value that is not allowed."""
    try:
        loaded = yaml.safe_load(Path(path).read_text())
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as damage:
        raise BagError(f"topic map {path} cannot be read: {damage}") from damage
    if not isinstance(loaded, dict):
        raise BagError(f"topic map {path} is not a mapping; its keys are {', '.join(KEYS)}")
    unknown = set(map(str, loaded)) - set(KEYS)
    if unknown:
        raise BagError(
            f"topic map {path} has unknown {', '.join(sorted(unknown))}; known are {', '.join(KEYS)}"
        )
    stamps, tolerance = loaded.get("stamps", "header"), loaded.get("tolerance_s", TOLERANCE_S)
    if stamps not in ("header", "receive"):
        raise BagError(f"topic map {path}: stamps = {stamps!r}; allowed are header, receive")
    if not isinstance(tolerance, float | int) or not 0.0 <= tolerance <= 1.0:
        raise BagError(f"topic map {path}: tolerance_s = {tolerance!r}; allowed is 0 to 1 s")
    names = {key: _names(path, key, loaded.get(key, {})) for key in _MAPPINGS}
    made = TopicMap(
        **names, poses=str(loaded.get("poses", "")), by_header=stamps == "header", tolerance_s=tolerance
    )
    if not (made.vehicles or made.poses or made.signals):
        raise BagError(f"topic map {path} maps nothing; give vehicles, poses or signals")
    return made


def _names(path: Path | str, key: str, value: object) -> dict[str, str]:
    if not isinstance(value, dict):
        raise BagError(f"topic map {path}: {key} = {value!r}; expected a mapping of names to names")
    return {str(left): str(right) for left, right in value.items()}
