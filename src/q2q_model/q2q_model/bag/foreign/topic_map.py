"""Topic maps: YAML files that assign the topics of a bag to vehicles and signals.

vehicles:                 # one topic per vehicle: PoseStamped, TransformStamped or Odometry
  cf1: /vicon/cf1/pose
  cf2: /cf2/odom
poses: /poses             # also or instead: NamedPoseArray, all vehicles in one message
rename: {cf231: cf1}      # name in `poses`: name of the vehicle
references:               # as `vehicles`, or Position or FullState of Crazyswarm2
  cf1: /cf1/cmd_position
signals:                  # also or instead: topics of q2q_msgs under other names (`mocap`: only instead)
  command: /room/command
stamps: header            # of poses and references; or receive, if their headers have no stamps
tolerance_s: 0.005        # poses captured within this time form one frame
frames: [world, map]      # only if headers have several names of one and the same coordinate frame
"""

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from q2q_model.bag.storage.errors import BagError
from q2q_model.counted import first_of
from q2q_model.documents.plain_values import from_plain
from q2q_model.documents.yaml_text import load_yaml
from q2q_model.nearest_name import name_hint
from q2q_model.signals.topic_names import TICK_TOPICS

TOLERANCE_S = 0.005
"""Half a period of VICON at 100 Hz [s]."""
MOST_KEYS = 3
"""Most keys of a topic in an error."""


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
    stamps: Literal["header", "receive"] = "header"
    """Time of poses and references is the stamp of the header, or of the recorder; signals have their own."""
    tolerance_s: float = TOLERANCE_S
    frames: tuple[str, ...] = ()
    """Names of the one coordinate frame of poses and references; empty if all headers have the same."""

    def __post_init__(self) -> None:
        """Raise ValueError, with what is allowed, if nothing, no topic of q2q, or a topic twice is mapped."""
        if not 0.0 <= self.tolerance_s <= 1.0:
            raise ValueError(f"tolerance_s = {self.tolerance_s}; must be in [0, 1] s")
        for topic in self.signals:
            if topic not in TICK_TOPICS:
                raise ValueError(f"signals: q2q has no topic {topic!r}; {name_hint(topic, TICK_TOPICS)}")
        given = "vehicles" if self.vehicles else "poses" if self.poses else ""
        if given and "mocap" in self.signals:
            raise ValueError(
                f"{given} and signals: mocap are both mapped; keep one of them, as each gives the poses of "
                "all vehicles and the ticks"
            )
        if self.references and "reference" in self.signals:
            raise ValueError(
                "references and signals: reference are both mapped; keep one of them: positions would come "
                "from one, velocities and accelerations from the other"
            )
        if not (self.vehicles or self.poses or self.signals):
            raise ValueError("it maps nothing; give vehicles, poses or signals")
        for topic, keys in self._keys_of_topics().items():
            if len(keys) > 1:
                raise ValueError(
                    f"topic {topic} is given for {' and '.join(first_of(keys, MOST_KEYS))}; give each its "
                    "own; only `poses` takes several vehicles from a topic"
                )

    def _keys_of_topics(self) -> dict[str, list[str]]:
        """Return the keys at which each topic of poses and references stands."""
        found: defaultdict[str, list[str]] = defaultdict(list)
        for section, topics in (("vehicles", self.vehicles), ("references", self.references)):
            for vehicle, topic in topics.items():
                found[topic].append(f"{section}.{vehicle}")
        if self.poses:
            found[self.poses].append("poses")
        return found

    @property
    def by_header(self) -> bool:
        """Return whether time is the stamp of the header."""
        return self.stamps == "header"


def load_topic_map(path: Path | str) -> TopicMap:
    """Return the map in a YAML file; raise BagError for a key or value that is not allowed."""
    try:
        return from_plain(TopicMap, load_yaml(Path(path)), str(path))
    except ValueError as error:
        raise BagError(f"topic map {error}") from error
