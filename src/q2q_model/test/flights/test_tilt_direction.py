"""Attitudes that lean away from where vehicles accelerate are doubted, for any turn of the world."""

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from q2q_model.flights.joined_flight import flight_from_signals
from q2q_model.flights.tables.flight_table import POS, attitude, flight_table
from q2q_model.flights.tables.table_file import read_columns
from q2q_model.flights.units_and_frames.frame_notes import axis_notes
from q2q_model.flights.units_and_frames.tilt_direction import tilt_direction_reason
from q2q_model.geometry.rotations import quat_from_euler, quat_from_vector, quat_multiply, rotate
from q2q_model.signals.values import Array, MocapFrame
from q2q_model.vehicle.constants import GRAVITY

DATA = Path(os.environ.get("Q2Q_DATA", "../shared/data"))
T = np.linspace(0.0, 19.99, 2000)
CONJUGATE = np.array([-1.0, -1.0, -1.0, 1.0])


def circle(yaw: float = 0.0) -> tuple[Array, Array]:
    """Return positions and attitudes of a vehicle on a circle of 0.5 m in 5 s, (T, 1, 3) and (T, 1, 4)."""
    rate = 0.4 * np.pi
    pos = 0.5 * np.stack([np.sin(rate * T), np.cos(rate * T), 0.0 * T], axis=1)
    acc = -(rate**2) * pos
    lean = quat_from_euler(-np.arctan2(acc[:, 1], GRAVITY), np.arctan2(acc[:, 0], GRAVITY), 0.0 * T)
    return pos[:, None], quat_multiply(lean, quat_from_euler(0.0, 0.0, yaw))[:, None]


def reason(pos: Array, quat: Array) -> str:
    return tilt_direction_reason(T, ("cf1",), pos, quat)


@pytest.mark.parametrize("yaw", [0.0, 1.0, -1.4, 3.0])
@pytest.mark.parametrize("askew", [0.0, 0.1])
def test_attitudes_of_body_to_world_raise_no_doubt(yaw: float, askew: float) -> None:
    pos, quat = circle(yaw)
    assert not reason(pos, quat_multiply(quat, quat_from_euler(0.0, askew, 0.0)))


@pytest.mark.parametrize("yaw", [0.0, 1.0, -1.2])
def test_attitudes_of_world_to_body_are_doubted_with_the_correlation(yaw: float) -> None:
    pos, quat = circle(yaw)
    found = reason(pos, quat * CONJUGATE)
    assert "cf1 accelerates to the side that its attitude leans away from" in found
    assert f"(correlation {-np.cos(yaw):.2f}, expected about 1)" in found
    turn = quat_from_vector(np.array([0.0, 0.0, 0.7]))
    assert not reason(rotate(turn, pos), quat_multiply(turn, quat))


def test_rest_level_attitudes_and_unknown_ones_are_not_judged() -> None:
    pos, quat = circle()
    assert not reason(0.05 * pos, quat * CONJUGATE)
    assert not reason(pos, np.broadcast_to([0.0, 0.0, 0.0, 1.0], quat.shape))
    assert not reason(pos, np.full_like(quat, np.nan))
    assert not tilt_direction_reason(T[:200], ("cf1",), pos[:200], quat[:200] * CONJUGATE)


def test_holes_are_not_bridged() -> None:
    pos, quat = circle()
    pos[500:600], pos[1200:1250] = np.nan, np.nan
    assert not reason(pos, quat)
    assert reason(pos, quat * CONJUGATE)


@pytest.mark.skipif(not DATA.is_dir(), reason=f"no recorded flights in {DATA}: set Q2Q_DATA")
def test_public_flights_raise_the_doubt_only_if_their_attitudes_are_conjugated() -> None:
    for file in sorted(DATA.glob("n*/*_s*.parquet")):
        table = flight_table(read_columns(file))
        pos, quat = table.vectors(POS), attitude(table)
        assert not tilt_direction_reason(table.t, table.names, pos, quat)
        conjugated = tilt_direction_reason(table.t, table.names, pos, quat * CONJUGATE)
        assert ("accelerates to the side" in conjugated) == ("takeoff" not in file.stem)


def test_the_doubt_is_a_note_on_a_flight_whose_true_frame_is_not_known() -> None:
    pos, quat = circle()
    frames = [MocapFrame(t=t, names=("cf1",), pos=pos[k], quat=quat[k] * CONJUGATE) for k, t in enumerate(T)]
    flight = flight_from_signals("room", {"mocap": frames}).flight
    (note,) = axis_notes(flight)
    assert note.startswith("flight room: cf1 accelerates to the side")
    assert axis_notes(replace(flight, true_pos=flight.mocap_pos)) == []
