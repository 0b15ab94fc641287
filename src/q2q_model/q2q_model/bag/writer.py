"""Writer of a bag, from serialised messages or signals; a crash costs at most the last second.

A chunk is closed after CHUNK_NS of bag time. Closed chunks of a process that was killed, or whose disk was
full, can be read (q2q_model.bag.storage.salvage). Each compressed chunk has a checksum that detects damage.
"""

from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from types import TracebackType
from typing import Never, Self

from rosbags.interfaces import (
    Connection,
    Qos,
    QosDurability,
    QosHistory,
    QosLiveliness,
    QosReliability,
    QosTime,
)
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer

from q2q_model.bag.flight_facts import FlightFacts
from q2q_model.bag.storage.definitions import definition_of
from q2q_model.bag.storage.errors import BagError
from q2q_model.signals.cdr.cdr_writer import encode
from q2q_model.signals.layout import LAYOUTS, Signal
from q2q_model.signals.stamps import stamp_from_time, time_from_stamp

VERSION = 9
"""Version of metadata.yaml in ROS 2 Jazzy."""
ZSTD_LEVEL = -1
"""Level of compression: bags are 5 to 12 % larger than by the default 3, in 0.4 of the time."""
CHUNK_NS = 10**9
"""Bag time in a chunk [ns], the most that a kill loses."""
_FOR_EVER = QosTime(sec=9223372036, nsec=854775807)
"""RMW_DURATION_INFINITE."""


@dataclass(frozen=True, slots=True)
class OfferedQos:
    """Quality of service offered by the publisher of a topic."""

    reliable: bool = True
    transient_local: bool = False
    depth: int = 1


class BagWriter:
    """Bag open for writing; a context manager."""

    def __init__(
        self,
        path: Path | str,
        facts: FlightFacts | None = None,
        *,
        compress: bool = True,
    ) -> None:
        """Create the bag's folder `path`; closing writes `facts` to its metadata.

        Without `compress`, chunks have no checksum either: for a bag that is read once and deleted.

        Raises BagError if the path exists, or the folder cannot be created.
        """
        self.path = Path(path)
        if self.path.exists():
            raise BagError(f"{self.path} exists already: choose another name, or delete it")
        self._chunk_begin: int | None = None
        self._closed = False
        self._types: dict[str, str] = {}
        self._writer = Writer(self.path, version=VERSION, storage_plugin=StoragePlugin.MCAP)
        if compress:
            self._writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
        for name, value in (facts or FlightFacts()).known.items():
            self._writer.set_custom_data(name, value)
        try:
            self._writer.open()
        except OSError as refused:
            raise BagError(f"cannot create the bag folder {self.path}: {refused.strerror}") from refused
        self._connections: dict[str, Connection] = {}
        self._name_as_rosbag2()
        if compress:
            storage = self._writer.storage
            storage.compressor = partial(storage.compressor, options=_zstd_options())

    @property
    def topics(self) -> dict[str, str]:
        """Return every topic and its type."""
        return dict(self._types)

    def add_topic(self, topic: str, type_name: str, qos: OfferedQos | None = None) -> None:
        """Announce a topic of messages `type_name`, e.g. "q2q_msgs/msg/MocapFrame".

        Raises BagError for an unknown type, or a topic announced with another type.
        """
        self._check_open()
        if self._types.get(topic, type_name) != type_name:
            raise BagError(f"topic {topic} has type {self._types[topic]}; cannot write {type_name} to it")
        if topic in self._types:
            return
        definition, digest = definition_of(type_name)
        offered = [_profile(qos or OfferedQos())]
        self._connections[topic] = self._writer.add_connection(
            topic, type_name, msgdef=definition, rihs01=digest, offered_qos_profiles=offered
        )
        self._types[topic] = type_name

    def write_raw(self, topic: str, stamp_ns: int, data: bytes) -> None:
        """Write a serialised message at a bag time [ns].

        Raises BagError for an unannounced topic, or if the disk takes no more: the bag is closed then.
        """
        self._check_open()
        if topic not in self._connections:
            known = ", ".join(self._types) or "none"
            raise BagError(f"topic {topic} is not announced: call add_topic first; announced: {known}")
        begin = self._chunk_begin
        if begin is not None and abs(stamp_ns - begin) >= CHUNK_NS:
            self.flush()
        try:
            self._writer.write(self._connections[topic], stamp_ns, data)
        except OSError as refused:
            self._give_up(refused)
        self._chunk_begin = stamp_ns if self._chunk_begin is None else self._chunk_begin

    def write_signal(self, topic: str, stamp_ns: int, signal: Signal) -> None:
        """Write a signal at a bag time [ns], announcing its topic; the header's stamp is `signal.t`.

        The header takes `stamp_ns` where that equals `signal.t`, a float exact to 1 ns for 26 days only.
        """
        if topic not in self._connections:
            self.add_topic(topic, f"q2q_msgs/msg/{LAYOUTS[type(signal)].message}")
        header_ns = stamp_ns if time_from_stamp(stamp_ns) == signal.t else stamp_from_time(signal.t)
        self.write_raw(topic, stamp_ns, encode(signal, header_ns))

    def flush(self) -> None:
        """Close the running chunk and hand it to the operating system."""
        self._check_open()
        storage = self._writer.storage
        if self._chunk_begin is not None:
            try:
                storage.close_chunk()
                storage.bio.flush()
            except OSError as refused:
                self._give_up(refused)
        self._chunk_begin = None

    def close(self) -> None:
        """Write the index and metadata.yaml; further calls do nothing."""
        if not self._closed:
            try:
                self._writer.close()
            except OSError as refused:
                self._give_up(refused)
            self._closed = True

    def _give_up(self, refused: OSError) -> Never:
        """Close the bag and raise BagError: the disk takes no more."""
        self._closed = True
        with suppress(OSError):
            self._writer.storage.bio.close()
        raise BagError(
            f"cannot write to the bag {self.path}: {refused.strerror}; its messages so far can be read"
        ) from refused

    def __enter__(self) -> Self:
        """Return the writer."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close the bag, also after an error."""
        self.close()

    def _check_open(self) -> None:
        if self._closed:
            raise BagError(f"bag {self.path} is closed")

    def _name_as_rosbag2(self) -> None:
        storage = self._writer.storage
        named = self.path / f"{self.path.name}_0.mcap"
        storage.path.rename(named)
        storage.path = named


def _zstd_options() -> dict[int, int]:
    from backports.zstd import CompressionParameter

    return {CompressionParameter.checksum_flag: 1, CompressionParameter.compression_level: ZSTD_LEVEL}


def _profile(qos: OfferedQos) -> Qos:
    return Qos(
        history=QosHistory.KEEP_LAST,
        depth=qos.depth,
        reliability=QosReliability.RELIABLE if qos.reliable else QosReliability.BEST_EFFORT,
        durability=QosDurability.TRANSIENT_LOCAL if qos.transient_local else QosDurability.VOLATILE,
        deadline=_FOR_EVER,
        lifespan=_FOR_EVER,
        liveliness=QosLiveliness.AUTOMATIC,
        liveliness_lease_duration=_FOR_EVER,
        avoid_ros_namespace_conventions=False,
    )
