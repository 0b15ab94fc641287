"""What motion capture gets wrong for long is told once, with the vehicles, and when it is over."""

import numpy as np

from q2q_model.estimation.filter_report import MocapLies
from q2q_model.estimation.mocap_filter import MocapFilter
from q2q_model.estimation.mocap_filter_params import MocapFilterParams
from q2q_model.geometry.rotations import identity_quat
from q2q_model.node.mocap_troubles import LASTING, MocapTroubles
from q2q_model.signals.values import Array, MocapFrame

PAIR = ("cf1", "cf2")
PLACES = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 1.0]])
NOTHING = MocapLies((), ())
DT = 0.01


def told(lies: MocapLies, ticks: int) -> list[str]:
    troubles = MocapTroubles()
    return [line for k in range(ticks) if (line := troubles.take(k * DT, lies))]


def test_trouble_is_told_once_it_lasts_with_its_vehicles() -> None:
    lasts = round(LASTING / DT) + 2
    for lies, word in (
        (MocapLies(PAIR, ()), "exchanged"),
        (MocapLies((), PAIR), "repeat"),
        (MocapLies((), (), PAIR), "in metres"),
    ):
        assert told(lies, lasts - 2) == []
        (line,) = told(lies, 10 * lasts)
        assert word in line
        assert "cf1, cf2" in line
    assert told(NOTHING, lasts) == []


def test_its_end_is_told_and_interrupted_trouble_is_not() -> None:
    troubles, flicker = MocapTroubles(), MocapTroubles()
    for k in range(100):
        troubles.take(k * DT, MocapLies(PAIR, ()))
        assert flicker.take(k * DT, MocapLies(PAIR, ()) if k % 20 else NOTHING) == ""
    assert troubles.text
    assert "again" in troubles.take(1.0, NOTHING)
    assert troubles.text == ""


def seen_by(block: MocapFilter, k: int, places: Array) -> MocapLies:
    block.update(MocapFrame(k * DT, PAIR, places, identity_quat((2,))))
    return block.lies


def test_a_filter_knows_whose_names_are_exchanged_and_whose_poses_repeat() -> None:
    block, noise = MocapFilter(MocapFilterParams(), PAIR), np.random.default_rng(1)
    for k in range(50):
        places = PLACES + noise.normal(0.0, 3e-4, (2, 3))
        assert seen_by(block, k, places) == NOTHING
    other = PLACES + noise.normal(0.0, 3e-4, (2, 3))
    assert seen_by(block, 50, other[::-1].copy()) == MocapLies(PAIR, ())
    half = np.stack([places[0], PLACES[1] + noise.normal(0.0, 3e-4, 3)])
    assert seen_by(block, 51, half) == MocapLies((), ("cf1",))
    assert seen_by(block, 52, PLACES + noise.normal(0.0, 3e-4, (2, 3))) == NOTHING


def test_a_filter_knows_whose_positions_are_in_millimetres() -> None:
    block = MocapFilter(MocapFilterParams(), ())
    assert seen_by(block, 0, 1e3 * PLACES) == MocapLies((), (), PAIR)
    assert seen_by(block, 1, PLACES * [[1.0], [1e3]]) == MocapLies((), (), ("cf2",))
    assert seen_by(block, 2, PLACES * [[1.0], [np.nan]]) == NOTHING
