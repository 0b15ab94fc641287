"""Time bags against mcap-ros2-support, and the mocap filter against one vehicle at a time."""

from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time

import numpy as np
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from mcap_ros2.writer import Writer as ReferenceWriter

from q2q_model.bag import BagReader, BagWriter
from q2q_model.bag.storage.definitions import definition_of
from q2q_model.estimation.mocap_filter import MocapFilter
from q2q_model.estimation.mocap_filter_params import MocapFilterParams
from q2q_model.geometry.rotations import identity_quat
from q2q_model.signals.values import MocapFrame
from row import Row

MESSAGES = 5000
"""Frames of two vehicles: 50 s at 100 Hz."""
REPEATS = 3
"""The best of as many counts: the machine does other things too."""
STEP_NS = 10_000_000
TYPE = "q2q_msgs/msg/MocapFrame"
REFERENCE = "mcap-ros2-support"


def run() -> list[Row]:
    """Return the rows of this area."""
    frames = _frames(2, MESSAGES)
    with TemporaryDirectory() as folder:
        rows = _writing(Path(folder), frames) + _reading(Path(folder))
    return rows + [row for vehicles in (2, 100) for row in _filtering(vehicles)]


def _writing(folder: Path, frames: list[MocapFrame]) -> list[Row]:
    ours = min(_seconds(lambda k=k: _write(folder / f"ours{k}", frames)) for k in range(REPEATS))
    reference = min(
        _seconds(lambda k=k: _write_reference(folder / f"reference{k}.mcap", frames)) for k in range(REPEATS)
    )
    return [Row("write frames to a bag", MESSAGES / ours, "1/s", REFERENCE, reference / ours)]


def _reading(folder: Path) -> list[Row]:
    bag = folder / "ours0"
    ours = min(_seconds(lambda: _drain(BagReader(bag).signals())) for _ in range(REPEATS))
    reference = min(_seconds(lambda: _read_reference(bag / "ours0_0.mcap")) for _ in range(REPEATS))
    return [Row("read frames from a bag", MESSAGES / ours, "1/s", REFERENCE, reference / ours)]


def _filtering(vehicles: int) -> list[Row]:
    frames = _frames(vehicles, 1000)
    alone = [MocapFrame(one.t, ("cf0",), one.pos[:1], one.quat[:1]) for one in frames]
    ours, reference = _filtered(frames), vehicles * _filtered(alone)
    name = f"filter a frame of {vehicles} vehicles"
    return [Row(name, 1e6 * ours / len(frames), "us", "one vehicle at a time", reference / ours)]


def _filtered(frames: list[MocapFrame]) -> float:
    """Return the processor time that a filter takes for frames [s]."""
    filters = [MocapFilter(MocapFilterParams(), frames[0].names) for _ in range(1 + REPEATS)]
    _drain(map(filters[0].update, frames))  # loads the compiled loops
    return min(_seconds(lambda one=one: _drain(map(one.update, frames))) for one in filters[1:])


def _frames(vehicles: int, count: int) -> list[MocapFrame]:
    rng = np.random.default_rng(0)
    names, base = tuple(f"cf{k}" for k in range(vehicles)), rng.uniform(-5.0, 5.0, (vehicles, 3))
    quat = identity_quat((vehicles,))
    return [
        MocapFrame(
            tick * STEP_NS * 1e-9,
            names,
            base + np.sin(0.01 * tick) + rng.normal(0.0, 1e-3, (vehicles, 3)),
            quat,
        )
        for tick in range(count)
    ]


def _write(path: Path, frames: list[MocapFrame]) -> None:
    with BagWriter(path) as bag:
        for tick, frame in enumerate(frames):
            bag.write_signal("/mocap", tick * STEP_NS, frame)


def _write_reference(path: Path, frames: list[MocapFrame]) -> None:
    with path.open("wb") as stream, ReferenceWriter(stream) as writer:
        schema = writer.register_msgdef(TYPE, definition_of(TYPE)[0])
        for tick, frame in enumerate(frames):
            sec, nanosec = divmod(tick * STEP_NS, 1_000_000_000)
            message = {
                "header": {"stamp": {"sec": sec, "nanosec": nanosec}, "frame_id": "world"},
                "names": frame.names,
                "position": frame.pos.ravel().tolist(),
                "orientation": frame.quat.ravel().tolist(),
            }
            writer.write_message("/mocap", schema, message, log_time=tick * STEP_NS)


def _read_reference(path: Path) -> None:
    with path.open("rb") as stream:
        _drain(make_reader(stream, decoder_factories=[DecoderFactory()]).iter_decoded_messages())


def _drain(values: object) -> None:
    for _ in values:
        pass


def _seconds(job: Callable[[], None]) -> float:
    begin = process_time()
    job()
    return process_time() - begin
