"""Flights in bags of other software: poses under any topic, assigned by a topic map."""

from collections.abc import Sequence
from pathlib import Path

from q2q_model.bag.foreign.clock_offset import clock_remarks
from q2q_model.bag.foreign.header_frames import check_frames
from q2q_model.bag.foreign.mapped_poses import mapped_frames, rows_by_vehicle, sorted_rows
from q2q_model.bag.foreign.pose_messages import POSITION, SETPOINTS
from q2q_model.bag.foreign.references import References, with_references
from q2q_model.bag.foreign.topic_map import TopicMap
from q2q_model.bag.storage.bag_path import flight_name
from q2q_model.bag.storage.errors import BagError, warn_of_repairs
from q2q_model.bag.storage.open_source import open_source
from q2q_model.bag.storage.own_definition import check_fields
from q2q_model.bag.storage.source import Channel, Source
from q2q_model.flights.flight import Flight
from q2q_model.flights.joined_flight import flight_from_signals
from q2q_model.signals.cdr.cdr_format import BadMessageError
from q2q_model.signals.cdr.cdr_reader import SignalReader
from q2q_model.signals.layout import LAYOUTS, SIGNALS, Signal
from q2q_model.signals.topic_names import TICK_TOPICS


def read_mapped_flight(path: Path | str, topic_map: TopicMap) -> Flight:
    """Return the flight in a bag by a topic map; NaN where nothing was recorded.

    Raises:
        BagError: no bag, a mapped topic missing or of a wrong type, damage, several coordinate frames, clocks
            without overlap.
    """
    source, channels = mapped_channels(path, topic_map)
    signals: dict[str, Sequence[Signal]] = {
        name: _signals(source, channels[topic]) for name, topic in topic_map.signals.items()
    }
    repairs: list[str] = []
    if topic_map.vehicles or topic_map.poses:
        signals["mocap"], repairs = mapped_frames(source, channels, topic_map)
    rows = rows_by_vehicle(source, channels, topic_map.references, topic_map, (*SETPOINTS, POSITION))
    given = {
        vehicle: References(table[:, 0], table[:, 1:4], table[:, 8:11], table[:, 11:])
        for vehicle, (table, _) in sorted_rows(source, rows, "references").items()
    }
    check_frames(source, channels, topic_map)
    try:
        joined = flight_from_signals(flight_name(path), signals)
        flight, pauses = with_references(joined.flight, given)
    except ValueError as misfit:
        raise BagError(f"bag {path}: {misfit}") from misfit
    clocks = clock_remarks(source, channels, topic_map)
    remarks = (*repairs, *joined.repairs, *pauses, *clocks)
    warn_of_repairs(source.repairs + tuple(f"bag {path}: {remark}" for remark in remarks))
    return flight


def mapped_channels(path: Path | str, topic_map: TopicMap) -> tuple[Source, dict[str, Channel]]:
    """Return a bag and its channels by topic; raise BagError if one is missing or of another type."""
    source = open_source(path)
    channels = {channel.topic: channel for channel in source.channels}
    mapped = (topic_map.vehicles, topic_map.references, topic_map.signals)
    mapped_topics = {topic for some in mapped for topic in some.values()} | set(
        filter(None, [topic_map.poses])
    )
    missing = sorted(mapped_topics - channels.keys())
    if missing:
        raise BagError(f"bag {path} has no topic {', '.join(missing)}; it has {', '.join(sorted(channels))}")
    for name, topic in topic_map.signals.items():
        if SIGNALS.get(holds := channels[topic].type_name) is not TICK_TOPICS[name]:
            expected = f"q2q_msgs/msg/{LAYOUTS[TICK_TOPICS[name]].message}"
            raise BagError(f"topic {topic} holds {holds}; {name} under signals needs {expected}")
        check_fields(source.path, channels[topic])
    return source, channels


def _signals(source: Source, channel: Channel) -> list[Signal]:
    reader: SignalReader[Signal] = SignalReader(SIGNALS[channel.type_name])
    try:
        return [reader.read(message.data) for message in source.read({channel.topic})]
    except BadMessageError as bad:
        raise BagError(f"bag {source.path}, topic {channel.topic}: {bad}") from bad
