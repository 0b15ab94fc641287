"""What motion capture gets wrong for long is reported once, with the vehicles, and when it is over."""

from dataclasses import replace

import numpy as np
import pytest

from q2q_model.estimation.filter_report import FrameTrouble
from q2q_model.estimation.mocap_filter import MocapFilter
from q2q_model.estimation.mocap_filter_params import MocapFilterParams
from q2q_model.estimation.mocap_troubles import LASTING, MocapTroubles
from q2q_model.geometry.rotations import identity_quat
from q2q_model.signals.values import Array, MocapFrame

PAIR = ("cf1", "cf2")
PLACES = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 1.0]])
NOTHING = FrameTrouble()
DT = 0.01


def reported(trouble: FrameTrouble, ticks: int) -> list[str]:
    troubles = MocapTroubles()
    return [line for k in range(ticks) if (line := troubles.take(k * DT, trouble))]


def test_trouble_is_reported_once_it_lasts_with_its_vehicles() -> None:
    lasts = round(LASTING / DT) + 2
    for trouble, word in (
        (FrameTrouble(exchanged=PAIR), "exchanged"),
        (FrameTrouble(frozen=PAIR), "repeat"),
        (FrameTrouble(outside=PAIR), "in metres"),
        (FrameTrouble(not_unit=PAIR), "unit length"),
        (FrameTrouble(missing=PAIR), "no position"),
    ):
        assert reported(trouble, lasts - 2) == []
        (line,) = reported(trouble, 10 * lasts)
        assert word in line
        assert "cf1, cf2" in line
    assert reported(NOTHING, lasts) == []


def test_its_end_is_reported_and_interrupted_trouble_is_not() -> None:
    troubles, flicker = MocapTroubles(), MocapTroubles()
    for k in range(100):
        troubles.take(k * DT, FrameTrouble(exchanged=PAIR))
        assert flicker.take(k * DT, FrameTrouble(exchanged=PAIR) if k % 20 else NOTHING) == ""
    assert troubles.text
    assert "again" in troubles.take(1.0, NOTHING)
    assert troubles.text == ""


def seen_by(block: MocapFilter, k: int, places: Array) -> FrameTrouble:
    block.update(MocapFrame(k * DT, PAIR, places, identity_quat((2,))))
    return block.trouble


def test_a_filter_knows_whose_names_are_exchanged_and_whose_poses_repeat() -> None:
    block, noise = MocapFilter(MocapFilterParams(), PAIR), np.random.default_rng(1)
    for k in range(50):
        places = PLACES + noise.normal(0.0, 3e-4, (2, 3))
        assert seen_by(block, k, places) == NOTHING
    other = PLACES + noise.normal(0.0, 3e-4, (2, 3))
    assert seen_by(block, 50, other[::-1].copy()) == FrameTrouble(exchanged=PAIR)
    half = np.stack([places[0], PLACES[1] + noise.normal(0.0, 3e-4, 3)])
    assert seen_by(block, 51, half) == FrameTrouble(frozen=("cf1",))
    assert seen_by(block, 52, PLACES + noise.normal(0.0, 3e-4, (2, 3))) == NOTHING


def test_a_filter_knows_whose_positions_are_in_millimetres() -> None:
    block = MocapFilter(MocapFilterParams(), ())
    assert seen_by(block, 0, 1e3 * PLACES) == FrameTrouble(outside=PAIR)
    assert seen_by(block, 1, PLACES * [[1.0], [1e3]]) == FrameTrouble(outside=("cf2",))


def test_a_filter_knows_who_has_no_position_whether_its_row_is_there_or_not() -> None:
    block = MocapFilter(MocapFilterParams(), (*PAIR, "cf3"))
    assert seen_by(block, 0, PLACES * [[1.0], [np.nan]]) == FrameTrouble(missing=("cf2", "cf3"))


@pytest.mark.parametrize("quat", [[0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 57.3], [1.0, 0.0, 0.0, 1.0]])
def test_a_filter_knows_whose_quaternions_are_none(quat: list[float]) -> None:
    block = MocapFilter(MocapFilterParams(), PAIR)
    for k in range(50):
        frame = MocapFrame(k * DT, PAIR, PLACES + 1e-4 * k, np.array([quat, [0.0, 0.0, 0.0, 1.0]]))
        block.update(frame)
        assert block.trouble == FrameTrouble(not_unit=("cf1",))
    markers = np.array([[np.nan] * 4, [0.0, 0.0, 0.0, 1.0]])  # of single markers, which have none
    block.update(replace(frame, t=1.0, pos=PLACES, quat=markers))
    assert block.trouble == NOTHING
