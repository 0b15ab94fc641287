"""Settings of `motion_capture_tracking`, as Crazyswarm2 ships them in `motion_capture.yaml`.

    /motion_capture_tracking:
      ros__parameters:
        topics: {poses: {version: 2}}
        marker_configurations: {default_single_marker: ...}
        dynamics_configurations: {default: ...}

Vehicles tracked by librigidbodytracker name their markers and dynamics in `crazyflies.yaml`, of which
Crazyswarm2 makes rigid bodies. The tracker ends at an unknown name without saying whose it is, so the
names are checked here.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Literal

from q2q_model.documents.plain_values import from_plain
from q2q_model.documents.yaml_text import load_yaml

TRACKED = "librigidbodytracker"
"""Tracking that needs markers and dynamics; with "vendor", the vendor's software knows the bodies."""


@dataclass(frozen=True, slots=True)
class _Poses:
    version: Annotated[Literal[1, 2], "1 (NamedPoseArray) or 2 (NamedPoseArrayV2)"] = 1


@dataclass(frozen=True, slots=True)
class _Topics:
    poses: _Poses = _Poses()


@dataclass(frozen=True, slots=True)
class MotionCapture:
    """Parameters of `motion_capture_tracking` that concern q2q; others are ignored."""

    topics: _Topics = _Topics()
    marker_configurations: Mapping[str, object] = field(default_factory=dict)
    dynamics_configurations: Mapping[str, object] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class _Node:
    ros__parameters: MotionCapture = MotionCapture()


@dataclass(frozen=True, slots=True)
class _Tracking:
    tracking: str = "vendor"
    marker: str = ""
    dynamics: str = ""


@dataclass(frozen=True, slots=True)
class _Tracked:
    enabled: bool = False
    type: object = None
    motion_capture: _Tracking | None = None


@dataclass(frozen=True, slots=True)
class _Fleet:
    robots: Mapping[str, _Tracked] = field(default_factory=dict)
    robot_types: Mapping[str, _Tracked | None] = field(default_factory=dict)


def motion_capture_from_file(path: str) -> MotionCapture:
    """Return the settings in a `motion_capture.yaml`.

    Raises:
        ValueError: the file cannot be read, or as motion_capture_from_document.
    """
    return motion_capture_from_document(load_yaml(Path(path)))


def motion_capture_from_document(document: object) -> MotionCapture:
    """Return the settings in a parsed `motion_capture.yaml`, whatever the name of its only node.

    Raises:
        ValueError: it is not the parameters of one node, or naming the wrong key.
    """
    nodes = from_plain(dict[str, _Node], document, "motion_capture.yaml", extra=True)
    if len(nodes) != 1:
        raise ValueError(
            f"motion_capture.yaml has {len(nodes)} nodes; must have one, motion_capture_tracking"
        )
    return next(iter(nodes.values())).ros__parameters


def check_tracking(settings: MotionCapture, crazyflies: object) -> None:
    """Check that markers and dynamics of every enabled vehicle of a parsed `crazyflies.yaml` exist.

    Raises:
        ValueError: naming vehicle, missing name and those that exist.
    """
    fleet = from_plain(_Fleet, crazyflies, "crazyflies.yaml", extra=True)
    for name, robot in fleet.robots.items():
        kind = fleet.robot_types.get(str(robot.type)) or _Tracked()
        tracking = robot.motion_capture or kind.motion_capture or _Tracking()
        if not robot.enabled or tracking.tracking != TRACKED:
            continue
        for key, wanted, known in (
            ("marker", tracking.marker, settings.marker_configurations),
            ("dynamics", tracking.dynamics, settings.dynamics_configurations),
        ):
            if wanted not in known:
                raise ValueError(
                    f"{name}: {key} = {wanted!r} in crazyflies.yaml is not under {key}_configurations of "
                    f"motion_capture.yaml, which has {', '.join(known) or 'none'}"
                )
