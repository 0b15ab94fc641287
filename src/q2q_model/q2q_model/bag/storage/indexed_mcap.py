"""Indexed MCAP files: channels from the summary, messages chunk by chunk.

This is the regular path for a rosbag2 folder of MCAP files (specification: mcap.dev). Message records are
found by their lengths alone, at a quarter of the cost of a reader that makes an object of every record. A
file that is not complete and indexed raises NotIndexedError and is left to other readers.

    record   op uint8 | length uint64 | content
    message  channel uint16 | sequence uint32 | log time uint64 | publish time uint64 | data
"""

import struct
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import BinaryIO

import yaml
from mcap.data_stream import ReadDataStream
from mcap.reader import make_reader
from mcap.records import Channel as ChannelRecord
from mcap.records import Chunk, ChunkIndex, Schema
from mcap.stream_reader import get_chunk_data_stream

from q2q_model.bag.storage.latched import channel_is_latched
from q2q_model.bag.storage.source import Channel

NEWEST = 9
"""Newest supported version of metadata.yaml."""
MESSAGE = 0x05
_RECORD = struct.Struct("<BQHIQQ")
"""Header of a message record."""
_LEAD = 9
"""Bytes of op and length."""

Logged = tuple[int, int, bytes, tuple[int, int]]
"""Channel number, log time [ns], data, place in the file (chunk, record): that of the order of recording."""


class NotIndexedError(ValueError):
    """Error for a bag that does not consist of complete, indexed MCAP files."""


class DamagedIndexError(ValueError):
    """Error for a file whose index lacks chunks, channels or types: readers that trust it would lose them."""


@dataclass(frozen=True, slots=True)
class IndexedFile:
    """Contents of a file and their offsets."""

    path: Path
    channels: Mapping[int, Channel]
    chunks: tuple[ChunkIndex, ...]
    """In the order of their first message."""


def indexed_files(bag: Path) -> list[IndexedFile]:
    """Return the indexes of a bag: a rosbag2 folder, or one .mcap file.

    Raises NotIndexedError for any other bag, DamagedIndexError for one that must be salvaged.
    """
    try:
        return [_index(file) for file in (_named_files(bag) if bag.is_dir() else [bag])]
    except (NotIndexedError, DamagedIndexError):
        raise
    except Exception as damage:  # a parser on damaged bytes raises anything
        raise NotIndexedError(f"{bag}: {type(damage).__name__}: {damage}") from damage


def messages_by_log_time(file: IndexedFile, topics: Collection[str]) -> Iterator[Logged]:
    """Yield the messages on these topics in the order of their log time.

    Damage raises an Exception when it is reached, and so do messages counted in the summary but missing in
    the chunks.
    """
    left = {number: one.count for number, one in file.channels.items() if one.topic in topics}
    waiting: list[Logged] = []
    with file.path.open("rb") as stream:
        for place, chunk in enumerate(file.chunks if left else ()):
            found = _messages_of(_unpacked(stream, chunk), left.keys(), chunk.chunk_start_offset)
            for number, *_ in found:
                left[number] -= 1
            waiting = sorted(waiting + found, key=lambda one: one[1])
            later = [one.message_start_time for one in file.chunks[place + 1 : place + 2]]
            ready = _count_before(waiting, later)
            yield from waiting[:ready]
            del waiting[:ready]
    if any(left.values()):
        raise ValueError(f"{sum(left.values())} messages counted in the summary are missing")


def _count_before(waiting: list[Logged], later: list[int]) -> int:
    """Return how many messages precede all later chunks."""
    if not later or not waiting or waiting[-1][1] < later[0]:
        return len(waiting)
    return sum(one[1] < later[0] for one in waiting)


def _named_files(bag: Path) -> list[Path]:
    """Return the files that a folder's metadata names."""
    info = yaml.safe_load((bag / "metadata.yaml").read_text(encoding="utf-8"))["rosbag2_bagfile_information"]
    files = [bag / Path(name).name for name in info["relative_file_paths"]]
    plain = info["storage_identifier"] == "mcap" and not info.get("compression_mode")
    if not (plain and info["version"] <= NEWEST and files and all(file.is_file() for file in files)):
        raise NotIndexedError(f"{bag} is not made of plain MCAP files")
    return files


def _index(file: Path) -> IndexedFile:
    with file.open("rb") as stream:
        reader = make_reader(stream)
        summary, profile = reader.get_summary(), reader.get_header().profile
    if summary is None or summary.statistics is None or profile != "ros2":
        raise NotIndexedError(f"{file} has no summary")
    known = len(summary.chunk_indexes)
    if 0 < known < summary.statistics.chunk_count:
        raise DamagedIndexError(f"{file}: {known} of {summary.statistics.chunk_count} chunks have an index")
    if known != summary.statistics.chunk_count or (summary.statistics.message_count and not known):
        raise NotIndexedError(f"{file} has messages without an index")
    listed, schemas = len(summary.channels), summary.schemas.keys()
    if listed < summary.statistics.channel_count:
        message = f"{listed} of {summary.statistics.channel_count} channels are in the summary"
        raise DamagedIndexError(f"{file}: {message}")
    if any(one.schema_id not in schemas for one in summary.channels.values()):
        raise DamagedIndexError(f"{file}: the summary lacks types of its channels")
    counts = summary.statistics.channel_message_counts
    channels = {
        number: _channel(channel, summary.schemas.get(channel.schema_id), counts.get(number, 0))
        for number, channel in summary.channels.items()
    }
    return IndexedFile(
        file, channels, tuple(sorted(summary.chunk_indexes, key=lambda one: one.message_start_time))
    )


def _channel(channel: ChannelRecord, schema: Schema | None, count: int) -> Channel:
    if schema is None or channel.message_encoding != "cdr":
        raise NotIndexedError(f"{channel.topic} is not CDR of a known type")
    definition = schema.data.decode() if schema.encoding else ""
    return Channel(channel.topic, schema.name, definition, count, channel_is_latched(channel.metadata))


def _unpacked(stream: BinaryIO, chunk: ChunkIndex) -> bytes:
    """Return a chunk's records after checking their checksum."""
    stream.seek(chunk.chunk_start_offset + _LEAD)
    content = BytesIO(stream.read(chunk.chunk_length - _LEAD))
    records, size = get_chunk_data_stream(Chunk.read(ReadDataStream(content)), validate_crc=True)
    unpacked: bytes = records.read(size)
    return unpacked


def _messages_of(records: bytes, selected: Collection[int], begin: int) -> list[Logged]:
    found: list[Logged] = []
    at, end, data_at = 0, len(records), _RECORD.size
    while at < end:
        if records[at] == MESSAGE:
            _, length, number, _, stamp_ns, _ = _RECORD.unpack_from(records, at)
            after = at + _LEAD + length
            if number in selected:
                found.append((number, stamp_ns, records[at + data_at : after], (begin, at)))
        else:
            after = at + _LEAD + int.from_bytes(records[at + 1 : at + _LEAD], "little")
        if after > end:
            raise ValueError("a record is longer than its chunk")
        at = after
    return found
