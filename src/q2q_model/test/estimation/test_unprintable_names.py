"""Names of motion capture that no report can show are not tracked."""

import numpy as np
from mocap_frames import IDEAL_SENSING, PAIR, frame_at, same, time_of, truth_at

from q2q_model.estimation.frame_rows import match_rows
from q2q_model.estimation.mocap_filter import MocapFilter
from q2q_model.geometry.rotations import identity_quat
from q2q_model.signals.values import MocapFrame

UNPRINTABLE = ("", " ", "cf1\n")


def test_blank_names_and_line_breaks_are_left_out_and_the_rest_of_the_frame_is_used() -> None:
    block, named = MocapFilter(IDEAL_SENSING, ()), MocapFilter(IDEAL_SENSING, PAIR)
    for tick in range(30):
        pos = np.concatenate([truth_at(tick)[0], [[2.0, 0.0, 1.0], [3.0, 0.0, 1.0], [4.0, 0.0, 1.0]]])
        frame = MocapFrame(time_of(tick), (*PAIR, *UNPRINTABLE), pos, identity_quat((5,)))
        assert same(block.update(frame), named.update(frame_at(tick)))
        assert not block.refuses_names


def test_names_that_are_only_no_topics_are_tracked() -> None:
    block = MocapFilter(IDEAL_SENSING, ())
    names = ("1cf", "cf 2", "cf\u2603")
    frame = MocapFrame(time_of(0), names, np.eye(3), identity_quat((3,)))
    assert block.update(frame).names == names


def test_names_that_could_be_tracked_are_counted_once() -> None:
    rows = match_rows(("cf1", "x", "x", *UNPRINTABLE), ("cf1",))
    assert (rows.tracks.tolist(), rows.repeated, rows.unknown) == ([0, -1, -1, -1, -1, -1], 1, 1)
