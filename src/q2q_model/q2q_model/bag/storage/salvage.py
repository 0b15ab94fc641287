"""Recovery of messages from a truncated or damaged MCAP file, record by record.

Reading ends where the file is truncated and skips chunks whose checksum fails. `losses` lists both.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from mcap.records import Channel, Chunk, Footer, McapRecord, Message, Schema
from mcap.stream_reader import StreamReader, breakup_chunk

from q2q_model.bag.storage.latched import channel_is_latched
from q2q_model.bag.storage.source import RawMessage
from q2q_model.counted import counted
from q2q_model.signals.stamps import time_from_stamp


@dataclass(frozen=True, slots=True)
class Salvage:
    """Recovered contents of a damaged file."""

    messages: tuple[RawMessage, ...]
    definitions: dict[str, str]
    """Topic -> message definition."""
    latched: frozenset[str]
    """Topics that were latched."""
    losses: tuple[str, ...]


class _Collector:
    """Messages so far, with the schemas and channels that later records refer to."""

    def __init__(self) -> None:
        self.schemas: dict[int, Schema] = {}
        self.channels: dict[int, Channel] = {}
        self.messages: list[RawMessage] = []
        self.definitions: dict[str, str] = {}
        self.orphans = 0

    def add(self, record: McapRecord) -> None:
        if isinstance(record, Schema):
            self.schemas[record.id] = record
        elif isinstance(record, Channel):
            self.channels[record.id] = record
        elif isinstance(record, Message):
            channel = self.channels.get(record.channel_id)
            schema = self.schemas.get(channel.schema_id) if channel else None
            if channel is None or schema is None:
                self.orphans += 1
            else:
                self.messages.append(RawMessage(channel.topic, record.log_time, record.data, schema.name))
                self.definitions[channel.topic] = schema.data.decode(errors="replace")


def salvage(file: Path) -> Salvage:
    """Return every readable message of an MCAP file, and a description of the losses."""
    collector, losses = _Collector(), []
    with file.open("rb") as stream:
        reader = StreamReader(stream, emit_chunks=True, record_size_limit=file.stat().st_size)
        for found in _records(reader, file.name):
            if isinstance(found, str):
                losses.append(found)
            else:
                collector.add(found)
    if collector.orphans:
        losses.append(f"{file.name}: {counted(collector.orphans, 'message')} of unknown channels dropped")
    latched = frozenset(one.topic for one in collector.channels.values() if channel_is_latched(one.metadata))
    return Salvage(tuple(collector.messages), collector.definitions, latched, tuple(losses))


def _records(reader: StreamReader, name: str) -> Iterator[McapRecord | str]:
    """Yield the records, with those in chunks, and a sentence for every loss."""
    records = iter(reader.records)
    while True:
        try:
            record = next(records)
        except StopIteration:
            return
        except Exception as cut:  # noqa: BLE001 - a parser on damaged bytes raises anything
            yield f"{name} is truncated or damaged ({type(cut).__name__}): the rest is not read"
            return
        if isinstance(record, Footer):
            return
        if not isinstance(record, Chunk):
            yield record
            continue
        try:
            yield from breakup_chunk(record, validate_crc=True)
        except Exception as damage:  # noqa: BLE001 - as above
            begin, end = time_from_stamp(record.message_start_time), time_from_stamp(record.message_end_time)
            yield f"{name}: a damaged chunk is dropped, {begin:.3f} to {end:.3f} s of bag time ({damage})"
