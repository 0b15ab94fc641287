"""Frames made of poses that come at times of their own."""

import numpy as np
from moving_poses import moving_poses

from q2q_model.bag.foreign.pose_frames import nearest_rows, pose_frames


def test_a_pose_of_a_slower_vehicle_is_in_one_frame_only() -> None:
    ticks, slow = np.arange(12) / 240.0, np.arange(3) / 50.0 + 0.001
    rows = nearest_rows(ticks, slow, 0.005)
    near = [int(np.argmin(np.abs(ticks - t))) for t in slow]
    assert near == [0, 5, 10]
    assert rows[near].tolist() == [0, 1, 2]
    assert (np.delete(rows, near) == -1).all()
    assert nearest_rows(np.array([0.0, 1.0]), np.array([0.5]), 1.0).tolist() == [0, -1]  # as near to both


def test_a_vehicle_keeps_its_poses_while_the_fullest_one_is_not_seen() -> None:
    every = np.arange(300) / 100.0
    hidden = (every > 0.995) & (every < 1.295)  # 30 ticks
    tracks = {
        "a": moving_poses(every[~hidden]),
        "b": moving_poses(every[50:250] + 0.002),
        "c": moving_poses(every[50:240]),
    }
    frames, repairs = pose_frames(tracks, 0.005)
    assert repairs == []
    assert len(frames) == 300
    seen = {name: [frame.t for frame in frames if name in frame.names] for name in tracks}
    assert {name: len(stamps) for name, stamps in seen.items()} == {"a": 270, "b": 200, "c": 190}
    assert np.allclose([frame.t for frame in frames if frame.names == ("b", "c")], every[hidden] + 0.002)


def test_poses_between_the_frames_make_no_ticks() -> None:
    every = np.arange(300) / 100.0
    drifting = every + np.linspace(0.0, 0.005, 300)  # the last 60 are more than 4 ms from both frames
    frames, repairs = pose_frames({"a": moving_poses(every), "b": moving_poses(drifting[:299])}, 0.004)
    assert len(frames) == 300
    assert repairs == ["59 of 299 poses of b match no tick: dropped"]
