"""Poses of the vehicles of a bag by a topic map: rows of each vehicle in time, and frames."""

from collections import Counter
from collections.abc import Mapping, Sequence

import numpy as np

from q2q_model.bag.foreign.pose_frames import Poses, clock_set_back, pose_frames
from q2q_model.bag.foreign.pose_messages import NAMED, POSES, Row, message_poses
from q2q_model.bag.foreign.topic_map import TopicMap
from q2q_model.bag.storage.errors import BagError
from q2q_model.bag.storage.source import Channel, Source
from q2q_model.signals.values import Array, MocapFrame, given_twice


def mapped_frames(
    source: Source, channels: dict[str, Channel], topic_map: TopicMap
) -> tuple[list[MocapFrame], list[str]]:
    """Return the mapped poses as one frame per tick, and remarks on poses left out."""
    tracks, twice = _tracks(source, channels, topic_map)
    try:
        frames, repairs = pose_frames(tracks, topic_map.tolerance_s)
    except ValueError as misfit:
        raise BagError(f"bag {source.path}: {misfit}") from misfit
    return frames, twice + repairs


def _tracks(
    source: Source, channels: dict[str, Channel], topic_map: TopicMap
) -> tuple[dict[str, Poses], list[str]]:
    """Return the poses of every vehicle, and remarks on those that a message has twice."""
    rows = rows_by_vehicle(source, channels, topic_map.vehicles, topic_map, tuple(POSES))
    named: dict[str, list[Row]] = {}
    twice: Counter[str] = Counter()
    if topic_map.poses:
        for found in message_poses(source, channels[topic_map.poses], topic_map, NAMED):
            twice.update(given_twice(name for name, _ in found))
            for name, row in _once(found):
                named.setdefault(name, []).append(row)
    remarks = [f"{n} messages of {topic_map.poses} name {name} twice: ignored" for name, n in twice.items()]
    _check_names(source, topic_map, list(named), remarks)
    rows |= {topic_map.rename.get(name, name): found for name, found in named.items()}
    if not rows:
        raise BagError("; ".join([f"bag {source.path} has no pose of any vehicle", *remarks]))
    return {
        vehicle: Poses(table[:, 0], table[:, 1:4], table[:, 4:8], back)
        for vehicle, (table, back) in sorted_rows(source, rows, "poses").items()
    }, remarks


def _once(found: Sequence[tuple[str, Row]]) -> list[tuple[str, Row]]:
    """Return the poses of vehicles that a message names once: which of two is true is not known."""
    twice = given_twice(name for name, _ in found)
    return [(name, row) for name, row in found if name not in twice]


def _check_names(source: Source, topic_map: TopicMap, named: Sequence[str], remarks: Sequence[str]) -> None:
    """Raise BagError if a vehicle has two sources of poses, or a name to replace never occurs."""
    absent = [name for name in topic_map.rename if name not in named]
    if absent:
        names = ", ".join(named) or ("none" if topic_map.poses else "none, as the topic map has no poses")
        never = f"rename has {', '.join(absent)}, which have no poses; names are {names}"
        raise BagError("; ".join([f"bag {source.path}: {never}", *remarks]))
    sources = dict(topic_map.vehicles)
    for name in named:
        vehicle = topic_map.rename.get(name, name)
        if vehicle in sources:
            raise BagError(
                f"bag {source.path}: {vehicle} has poses from {sources[vehicle]} and from {name} in "
                f"{topic_map.poses}; give one of them another name under rename"
            )
        sources[vehicle] = f"{name} in {topic_map.poses}"


def rows_by_vehicle(
    source: Source,
    channels: dict[str, Channel],
    topics: Mapping[str, str],
    topic_map: TopicMap,
    known: Sequence[str],
) -> dict[str, list[Row]]:
    """Return the rows of every vehicle from its own topic, whose type is one of `known`."""
    return {
        vehicle: [
            row for found in message_poses(source, channels[topic], topic_map, known) for _, row in found
        ]
        for vehicle, topic in topics.items()
    }


def sorted_rows(source: Source, rows: Mapping[str, list[Row]], what: str) -> dict[str, tuple[Array, float]]:
    """Return the rows of every vehicle by time, (rows, columns), and the most that a stamp goes back [s]."""
    empty = sorted(vehicle for vehicle, found in rows.items() if not found)
    if empty:
        raise BagError(f"bag {source.path} has no {what} of {', '.join(empty)}")
    tracks = {}
    for vehicle, found in rows.items():
        table = np.array(found)
        recorded = table[:, 0]
        back = float(np.max(np.maximum.accumulate(recorded) - recorded))
        table = table[np.argsort(recorded, kind="stable")]
        if len(table) > 1 and table[0, 0] == table[-1, 0]:
            raise BagError(
                f"bag {source.path}: all {len(table)} {what} of {vehicle} have the stamp {table[0, 0]:g} s; "
                "if headers are not filled, add `stamps: receive` to the topic map"
            )
        if step := clock_set_back(recorded):
            raise BagError(f"bag {source.path}, {what} of {vehicle}: {step}")
        tracks[vehicle] = table, back
    return tracks
