"""Opening of bags of any kind.

Complete MCAP files are read by their index (q2q_model.bag.storage.indexed_mcap), all others through rosbags.
An MCAP bag that was not closed (truncated by a kill, without metadata.yaml), or whose summary leaves out the
channels, is salvaged; `repairs` lists what that took.
"""

from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from rosbags.interfaces import Connection
from rosbags.rosbag1 import Reader as Ros1Reader
from rosbags.rosbag2 import Reader

from q2q_model.bag.storage.bag_path import FILES, ROS1_SUFFIX, is_bag, storage_files
from q2q_model.bag.storage.definition_encoding import unread_encoding
from q2q_model.bag.storage.errors import BagError
from q2q_model.bag.storage.indexed_mcap import (
    IndexedFile,
    NotIndexedError,
    indexed_files,
    messages_by_log_time,
)
from q2q_model.bag.storage.latched import connection_is_latched
from q2q_model.bag.storage.salvage import salvage
from q2q_model.bag.storage.source import Channel, RawMessage, Source
from q2q_model.counted import counted


def open_source(path: Path | str) -> Source:
    """Return the bag at `path`: a rosbag2 folder, an .mcap or .db3 file, or a ROS 1 .bag file.

    Raises BagError for a path that is no bag, or damage that cannot be repaired.
    """
    bag = Path(path)
    if not bag.exists():
        raise BagError(f"no bag at {bag}")
    if bag.is_dir() and not (bag / "metadata.yaml").exists():
        return _open_bare_folder(bag)
    if not is_bag(bag):
        kinds = ", ".join(FILES)
        raise BagError(f"{bag} is not a bag: give a rosbag2 folder or a file ({kinds})")
    try:
        return _regular(bag, [bag])
    except Exception as damage:  # noqa: BLE001 - a parser on damaged bytes raises anything
        why = f"{type(damage).__name__}: {damage}"
    if bag.is_dir() and not (bag / "metadata.yaml").read_text(errors="replace").strip():
        return _of_files(bag, f"the metadata.yaml of bag {bag} is empty (it was not closed)")
    return _salvaged(bag, why)


def _open_bare_folder(bag: Path) -> Source:
    if not storage_files(bag):
        raise BagError(f"{bag} is not a bag: it has neither metadata.yaml nor an .mcap or .db3 file")
    return _of_files(bag, f"bag {bag} has no metadata.yaml (it was not closed)")


def _of_files(bag: Path, lost: str) -> Source:
    """Return the bag in the files of a folder without metadata, salvaged if one of them is not whole."""
    files = storage_files(bag)
    whole = (
        f"{', '.join(file.name for file in files)}, {'which is' if len(files) == 1 else 'which are'} whole"
    )
    try:
        return _regular(bag, files, (f"{lost}; read from {whole}",))
    except Exception:  # noqa: BLE001 - a parser on damaged bytes raises anything
        return _salvaged(bag, lost)


def _regular(bag: Path, parts: Sequence[Path], repairs: tuple[str, ...] = ()) -> Source:
    """Return the bag in whole parts: itself, or its files in the order of recording."""
    try:
        return _indexed(bag, [file for part in parts for file in indexed_files(part)], repairs)
    except NotIndexedError:
        return _through_rosbags(bag, parts, repairs)


def _indexed(bag: Path, files: list[IndexedFile], repairs: tuple[str, ...]) -> Source:
    channels = _by_topic(one for file in files for one in file.channels.values())

    def read(topics: Collection[str]) -> Iterator[RawMessage]:
        done = 0
        try:
            for part, file in enumerate(files):
                for number, stamp_ns, data, place in messages_by_log_time(file, topics):
                    channel = file.channels[number]
                    done += 1
                    yield RawMessage(channel.topic, stamp_ns, data, channel.type_name, (part, *place))
        except Exception as damage:
            raise BagError(f"bag {bag} is damaged after {counted(done, 'message')}: {damage}") from damage

    return Source(bag, channels, read, repairs)


def _through_rosbags(bag: Path, parts: Sequence[Path], repairs: tuple[str, ...]) -> Source:
    ros1 = parts[0].suffix == ROS1_SUFFIX
    kind = Ros1Reader if ros1 else Reader
    stored: list[Channel] = []
    for part in parts:
        with kind(part) as reader:
            own = [_channel(connection) for connection in reader.connections]
        if not own and any(one.suffix == ".mcap" for one in storage_files(part)):
            raise ValueError("its summary has no channels")
        stored += own

    def read(topics: Collection[str]) -> Iterator[RawMessage]:
        done = 0
        try:
            for part in parts:
                with kind(part) as again:
                    chosen = [connection for connection in again.connections if connection.topic in topics]
                    for connection, stamp_ns, data in again.messages(chosen) if chosen else ():
                        done += 1
                        yield RawMessage(connection.topic, stamp_ns, bytes(data), connection.msgtype)
        except Exception as damage:
            raise BagError(f"bag {bag} is damaged after {counted(done, 'message')}: {damage}") from damage

    return Source(bag, _by_topic(stored), read, repairs, ros1)


def _by_topic(channels: Iterable[Channel]) -> tuple[Channel, ...]:
    """Return one channel for each topic and type: those of all publishers and files together."""
    found: dict[tuple[str, str], Channel] = {}
    for one in channels:
        key = (one.topic, one.type_name)
        before = found.get(key, Channel(*key, one.definition, 0, latched=True))
        found[key] = replace(one, count=before.count + one.count, latched=before.latched and one.latched)
    return tuple(found.values())


def _channel(connection: Connection) -> Channel:
    definition, latched = connection.msgdef.data, connection_is_latched(connection)
    return Channel(connection.topic, connection.msgtype, definition, connection.msgcount, latched)


def _salvaged(bag: Path, why: str) -> Source:
    files = [file for file in storage_files(bag) if file.suffix == ".mcap"]
    if not files:
        reason = unread_encoding(bag) or why
        raise BagError(f"bag {bag} cannot be read ({reason}); only MCAP bags can be repaired")
    recovered = [salvage(file) for file in files]
    messages = sorted(
        (found for one in recovered for found in one.messages), key=lambda found: found.stamp_ns
    )
    if not messages:
        raise BagError(f"bag {bag} cannot be read ({why}), and no message can be recovered")
    definitions = {topic: text for one in recovered for topic, text in one.definitions.items()}
    counts: dict[tuple[str, str], int] = {}
    for found in messages:
        counts[found.topic, found.type_name] = counts.get((found.topic, found.type_name), 0) + 1
    latched = {topic for one in recovered for topic in one.latched}
    channels = tuple(
        Channel(*key, definitions[key[0]], count, key[0] in latched) for key, count in counts.items()
    )
    repairs = (
        f"bag {bag}: {why}; recovered {counted(len(messages), 'message')}",
        *(loss for one in recovered for loss in one.losses),
    )

    def read(topics: Collection[str]) -> Iterator[RawMessage]:
        return (found for found in messages if found.topic in topics)

    return Source(bag, channels, read, repairs, is_cut=True)
