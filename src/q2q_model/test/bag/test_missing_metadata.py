"""A bag without its metadata is that of its files."""

from pathlib import Path

import numpy as np
import pytest
from bag_signals import MOCAP, PAIR, STEP_NS, random_signal
from rosbags.rosbag2 import StoragePlugin, Writer

from q2q_model.bag import (
    BagReader,
    BagRepairWarning,
    read_flight,
)
from q2q_model.bag.storage.definitions import jazzy_types
from q2q_model.signals.cdr.cdr_writer import encode
from q2q_model.signals.values import MocapFrame


@pytest.mark.parametrize("metadata", [None, ""])
@pytest.mark.parametrize("parts", [1, 3])
@pytest.mark.parametrize("storage", ["SQLITE3", "MCAP"])
def test_a_bag_without_metadata_is_that_of_its_whole_files(
    tmp_path: Path, storage: str, parts: int, metadata: str | None
) -> None:
    rng, bag = np.random.default_rng(0), tmp_path / "bag"
    frames = [random_signal(MocapFrame, tick, PAIR, rng) for tick in range(30)]
    bag.mkdir()
    plugin, size = StoragePlugin[storage], len(frames) // parts
    for part in range(parts):
        with Writer(tmp_path / f"part{part}", version=8, storage_plugin=plugin) as writer:
            connection = writer.add_connection("/mocap", MOCAP, typestore=jazzy_types())
            for tick in range(part * size, (part + 1) * size):
                writer.write(connection, tick * STEP_NS, encode(frames[tick], tick * STEP_NS))
        (file,) = (one for one in (tmp_path / f"part{part}").iterdir() if one.suffix in {".mcap", ".db3"})
        file.rename(bag / f"bag_{part}{file.suffix}")
    if metadata is not None:
        (bag / "metadata.yaml").write_text(metadata)
    reader = BagReader(bag)
    assert len(reader.repairs) == 1
    assert f"bag_{parts - 1}" in reader.repairs[0]
    assert [(one.topic, one.count) for one in reader.channels] == [("/mocap", 30)]
    with pytest.warns(BagRepairWarning, match="whole"):
        flight = read_flight(bag)
    assert np.array_equal(flight.mocap_pos, np.stack([frame.pos for frame in frames]))
