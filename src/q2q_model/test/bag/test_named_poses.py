"""Poses of all vehicles in one message, each by its name."""

import re
from pathlib import Path

import numpy as np
import pytest
from foreign_bags import SECOND_VERSION, TICKS, place, write_named

from q2q_model.bag import (
    BagError,
    TopicMap,
    read_mapped_flight,
)


@pytest.mark.parametrize(("kind", "extra"), [("NamedPoseArray", ""), ("NamedPoseArrayV2", SECOND_VERSION)])
def test_named_poses_of_both_versions_are_read_by_their_own_definition(
    tmp_path: Path, kind: str, extra: str
) -> None:
    write_named(tmp_path / "room.mcap", kind, extra)
    mapped = TopicMap(poses="/poses", rename={"cf231": "cf1"})
    flight = read_mapped_flight(tmp_path / "room.mcap", mapped)
    assert set(flight.names) == {"cf1", "cf232"}
    for tick in range(TICKS):
        assert flight.t[tick] == pytest.approx(1.0 + 0.01 * tick, abs=1e-9)
        for k, name in enumerate(("cf1", "cf232")):
            at = flight.mocap_pos[tick, flight.names.index(name)]
            if k == 0 and tick % 4 == 3:
                assert np.isnan(at).all()
            else:
                assert np.array_equal(at, place(tick, k)[0])
                assert np.array_equal(flight.mocap_quat[tick, flight.names.index(name)], place(tick, k)[1])


@pytest.mark.parametrize(
    ("mapped", "message"),
    [
        (TopicMap(poses="/poses", rename={"cf231": "cf232"}), "cf232 has poses from cf231 in /poses and"),
        (
            TopicMap({"cf231": "/cf231/pose"}, "/poses"),
            "cf231 has poses from /cf231/pose and from cf231 in /",
        ),
        (TopicMap(poses="/poses", rename={"cf2": "cf1"}), "rename has cf2, .*; names are cf231, cf232"),
        (
            TopicMap({"cf1": "/cf231/pose"}, rename={"cf2": "cf1"}),
            "rename has cf2, .* the topic map has no poses",
        ),
    ],
)
def test_a_vehicle_with_two_sources_or_a_name_of_nobody_is_refused(
    tmp_path: Path, mapped: TopicMap, message: str
) -> None:
    write_named(tmp_path / "room.mcap")
    with pytest.raises(BagError, match=message):
        read_mapped_flight(tmp_path / "room.mcap", mapped)


@pytest.mark.parametrize(
    ("mapped", "known"),
    [
        (
            TopicMap({"cf231": "/poses"}),
            "NamedPoseArray, .* must be one of PoseStamped, .*Array is read under poses",
        ),
        (
            TopicMap(poses="/cf231/pose"),
            "PoseStamped, which cannot be read here; must be one of NamedPoseArray,",
        ),
    ],
)
def test_poses_of_one_vehicle_and_of_all_are_not_taken_for_each_other(
    tmp_path: Path, mapped: TopicMap, known: str
) -> None:
    write_named(tmp_path / "room.mcap")
    with pytest.raises(BagError, match=known):
        read_mapped_flight(tmp_path / "room.mcap", mapped)


@pytest.mark.parametrize(
    ("numbers", "rename", "message"),
    [
        ((8, 7, 7), {"cf7": "cf1"}, "names are cf8; {} messages of /poses name cf7 twice: ignored"),
        ((7, 7, 7), {}, "has no pose of any vehicle; {} messages of /poses name cf7 twice: ignored"),
    ],
)
def test_where_poses_are_lacking_the_error_says_which_were_left_out(
    tmp_path: Path, numbers: tuple[int, ...], rename: dict[str, str], message: str
) -> None:
    file = tmp_path / "room.mcap"
    write_named(file, numbers=numbers)
    with pytest.raises(BagError, match=re.escape(message.format(TICKS))):
        read_mapped_flight(file, TopicMap(poses="/poses", rename=rename))


def test_a_vehicle_is_left_out_of_the_messages_that_name_it_twice(tmp_path: Path) -> None:
    """Only the second vehicle is in each fourth message, under the name that both have in the others."""
    write_named(tmp_path / "room.mcap", numbers=(7, 7, 8))
    left = TICKS - TICKS // 4
    with pytest.warns(UserWarning, match=f": {left} messages of /poses name cf7 twice: ignored"):
        flight = read_mapped_flight(tmp_path / "room.mcap", TopicMap(poses="/poses"))
    assert set(flight.names) == {"cf7", "cf8"}
    for tick in range(TICKS):
        at = flight.mocap_pos[tick]
        assert np.array_equal(at[flight.names.index("cf8")], place(tick, 2)[0])
        once = place(tick, 1)[0] if tick % 4 == 3 else (np.nan,) * 3
        np.testing.assert_array_equal(at[flight.names.index("cf7")], once)
