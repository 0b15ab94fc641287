"""What motion capture gets wrong for long is reported once, with the vehicles, and when it is over."""

from dataclasses import replace

import numpy as np
import pytest

from q2q_model.estimation.filter_report import FrameWarnings
from q2q_model.estimation.mocap_filter import MocapFilter
from q2q_model.estimation.mocap_filter_params import MocapFilterParams
from q2q_model.estimation.mocap_warnings import LASTING, MocapWarnings
from q2q_model.geometry.rotations import identity_quat
from q2q_model.signals.values import Array, Mask, MocapFrame

PAIR = ("cf1", "cf2")
PLACES = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 1.0]])
NOTHING = FrameWarnings()
DT = 0.01


def reported(wrong: FrameWarnings, ticks: int) -> list[str]:
    warnings = MocapWarnings()
    return [line for k in range(ticks) if (line := warnings.update(k * DT, wrong))]


def test_a_fault_is_warned_of_once_it_lasts_with_its_vehicles() -> None:
    lasts = round(LASTING / DT) + 2
    for wrong, word in (
        (FrameWarnings(exchanged=PAIR), "exchanged"),
        (FrameWarnings(frozen=PAIR), "repeat"),
        (FrameWarnings(outside=PAIR), "in metres"),
        (FrameWarnings(not_unit=PAIR), "unit length"),
        (FrameWarnings(upside_down=PAIR), "x, y, z, w"),
        (FrameWarnings(low_rate=PAIR), "coast_s"),
        (FrameWarnings(missing=PAIR), "no position"),
    ):
        assert reported(wrong, lasts - 2) == []
        (line,) = reported(wrong, 10 * lasts)
        assert word in line
        assert "cf1, cf2" in line
    assert reported(NOTHING, lasts) == []


def test_its_end_is_reported_and_interrupted_faults_are_not() -> None:
    warnings, flicker = MocapWarnings(), MocapWarnings()
    for k in range(100):
        warnings.update(k * DT, FrameWarnings(exchanged=PAIR))
        assert flicker.update(k * DT, FrameWarnings(exchanged=PAIR) if k % 20 else NOTHING) == ""
    assert warnings.text
    assert "again" in warnings.update(1.0, NOTHING)
    assert warnings.text == ""


def seen_by(block: MocapFilter, k: int, places: Array) -> FrameWarnings:
    block.update(MocapFrame(k * DT, PAIR, places, identity_quat((2,))))
    return block.warnings


def test_a_filter_knows_whose_names_are_exchanged_and_whose_poses_repeat() -> None:
    block, noise = MocapFilter(MocapFilterParams(), PAIR), np.random.default_rng(1)
    for k in range(50):
        places = PLACES + noise.normal(0.0, 3e-4, (2, 3))
        assert seen_by(block, k, places) == NOTHING
    other = PLACES + noise.normal(0.0, 3e-4, (2, 3))
    assert seen_by(block, 50, other[::-1].copy()) == FrameWarnings(exchanged=PAIR)
    half = np.stack([places[0], PLACES[1] + noise.normal(0.0, 3e-4, 3)])
    assert seen_by(block, 51, half) == FrameWarnings(frozen=("cf1",))
    assert seen_by(block, 52, PLACES + noise.normal(0.0, 3e-4, (2, 3))) == NOTHING


def test_a_filter_knows_whose_positions_are_in_millimetres() -> None:
    block = MocapFilter(MocapFilterParams(), ())
    assert seen_by(block, 0, 1e3 * PLACES) == FrameWarnings(outside=PAIR)
    assert seen_by(block, 1, PLACES * [[1.0], [1e3]]) == FrameWarnings(outside=("cf2",))


def test_a_filter_knows_who_has_no_position_whether_its_row_is_there_or_not() -> None:
    block = MocapFilter(MocapFilterParams(), (*PAIR, "cf3"))
    assert seen_by(block, 0, PLACES * [[1.0], [np.nan]]) == FrameWarnings(missing=("cf2", "cf3"))


@pytest.mark.parametrize("quat", [[0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 57.3], [1.0, 0.0, 0.0, 1.0]])
def test_a_filter_knows_whose_quaternions_are_none(quat: list[float]) -> None:
    block = MocapFilter(MocapFilterParams(), PAIR)
    for k in range(50):
        frame = MocapFrame(k * DT, PAIR, PLACES + 1e-4 * k, np.array([quat, [0.0, 0.0, 0.0, 1.0]]))
        block.update(frame)
        assert block.warnings == FrameWarnings(not_unit=("cf1",))
    markers = np.array([[np.nan] * 4, [0.0, 0.0, 0.0, 1.0]])  # of single markers, which have none
    block.update(replace(frame, t=1.0, pos=PLACES, quat=markers))
    assert block.warnings == FrameWarnings(rejected=PAIR)  # lost for 0.5 s, found once these have lasted


@pytest.mark.parametrize("ticks", [50, 600])  # rejected, and accepted after 4 s
@pytest.mark.parametrize("before", [0, 20])
def test_a_filter_knows_who_is_upside_down_by_its_quaternion(ticks: int, before: int) -> None:
    block, noise = MocapFilter(MocapFilterParams(), PAIR), np.random.default_rng(2)
    for k in range(before + ticks):
        quat = identity_quat((2,))
        if k >= before:
            quat[0] = quat[0, [3, 0, 1, 2]]
        block.update(MocapFrame(k * DT, PAIR, PLACES + noise.normal(0.0, 3e-4, (2, 3)), quat))
        assert block.warnings == (FrameWarnings(upside_down=("cf1",)) if k >= before else NOTHING)


@pytest.mark.parametrize(("noise", "reported"), [(0.005, False), (0.02, True), (0.03, True)])
def test_samples_that_are_too_noisy_for_the_gates_are_reported(noise: float, reported: bool) -> None:
    block, warnings, rng = MocapFilter(MocapFilterParams(), PAIR), MocapWarnings(), np.random.default_rng(0)
    lines = []
    for k in range(1000):
        found = seen_by(block, k, PLACES + rng.normal(0.0, noise, (2, 3)))
        lines.append(warnings.update(k * DT, found))
    assert any("many samples rejected: cf1, cf2" in line for line in lines) == reported
    assert any(lines) == reported


def many_rejected(times: Array, rejected: Mask) -> list[tuple[float, str]]:
    """Return what is logged, and when, of frames in which the samples of cf1 are rejected or not."""
    warnings, wrong = MocapWarnings(), FrameWarnings(rejected=("cf1",))
    lines = [
        (t, warnings.update(t, wrong if one else NOTHING)) for t, one in zip(times, rejected, strict=True)
    ]
    return [(t, line) for t, line in lines if line]


def test_many_samples_are_reported_as_soon_although_one_frame_a_second_is_late() -> None:
    times = np.linspace(0.0, 10.0, 1000, endpoint=False)
    rejected = times < 5.0
    after = np.arange(100, 1000, 100)
    late = np.insert(times, after, times[after - 1] - 1.5 * DT)
    found = many_rejected(late, np.insert(rejected, after, rejected[after - 1]))
    assert found == many_rejected(times, rejected)
    assert len(found) == 2


@pytest.mark.parametrize(
    ("back", "over"),
    [(0.5, 105.0 + 2.0 * np.log(0.918 / 0.125)), (50.0, 55.0)],  # 0.918 = 1 - exp(-5 s / 2 s)
)
def test_many_samples_before_a_clock_was_set_back_are_not_reported_for_ever(back: float, over: float) -> None:
    times = 100.0 + DT * np.arange(1500)
    rejected = times < 105.0
    (_, first), (end, last) = many_rejected(np.where(rejected, times, times - back), rejected)
    assert "many" in first
    assert "again" in last
    assert end == pytest.approx(over, abs=0.03)


def test_samples_rejected_now_and_then_or_after_a_gap_are_not_reported_and_many_are_until_they_are_few() -> (
    None
):
    rejected = FrameWarnings(rejected=("cf1",))
    seldom = MocapWarnings()
    assert not any(seldom.update(k * DT, NOTHING if k % 5 else rejected) for k in range(1000))
    assert not any(seldom.update(100.0 + k * DT, NOTHING if k % 5 else rejected) for k in range(1000))
    thirds = MocapWarnings()
    (line,) = [line for k in range(1000) if (line := thirds.update(k * DT, NOTHING if k % 3 else rejected))]
    assert "many" in line
    often = MocapWarnings()
    lines = [(k * DT, often.update(k * DT, rejected if k < 500 else NOTHING)) for k in range(1000)]
    (begin, first), (end, last) = [one for one in lines if one[1]]
    assert "many" in first
    assert "again" in last
    assert begin == pytest.approx(2.0 * np.log(1.0 / 0.75) + LASTING, abs=0.03)  # 1 - exp(-t / 2 s) > 0.25
    assert end == pytest.approx(5.0 + 2.0 * np.log(0.918 / 0.125), abs=0.03)
