"""Positions whose z is not the height are doubted, by the floor that no vehicle is below."""

import os
from pathlib import Path

import numpy as np
import pytest

from q2q_model.bag import BagWriter
from q2q_model.commands import identify
from q2q_model.flights.tables.flight_table import POS, flight_table
from q2q_model.flights.tables.table_file import read_columns
from q2q_model.flights.units_and_frames.up_axis import FLOOR, up_axis_reason
from q2q_model.signals.values import Array, MocapFrame

DATA = Path(os.environ.get("Q2Q_DATA", Path(__file__).parents[4].parent / "shared" / "data"))
NEEDS_DATA = pytest.mark.skipif(not DATA.is_dir(), reason=f"real flights are not at {DATA}: set Q2Q_DATA")


def circle(outliers: int = 0) -> Array:
    """Return 200 positions on a circle around the origin, 1 m up; some of them far below the floor."""
    angle = np.linspace(0.0, 2.0 * np.pi, 200, endpoint=False)
    pos = np.stack([np.cos(angle), np.sin(angle), np.ones(200)], axis=-1)
    pos[:outliers, 2] = -1.0
    return pos


def y_up(pos: Array) -> Array:
    """Return positions in a frame whose y is up."""
    return np.stack([pos[..., 0], pos[..., 2], -pos[..., 1]], axis=-1)


@pytest.mark.parametrize("outliers", [0, 4])
def test_a_flight_whose_y_is_up_is_doubted_and_one_whose_z_is_up_is_not(outliers: int) -> None:
    assert up_axis_reason(circle(outliers)) == ""
    output = up_axis_reason(y_up(circle(outliers)))
    below = (np.sin(np.linspace(0.0, 2.0 * np.pi, 200, endpoint=False)) > -FLOOR).mean()
    shares = f"z is below -0.1 m in {below:.0%} of the positions and y in {outliers / 200:.0%}: y may be up"
    assert output.startswith(shares)


@pytest.mark.parametrize("outliers", [0, 4])
def test_a_flight_whose_z_is_down_is_doubted_whatever_its_y_is(outliers: int) -> None:
    for aside in (-2.0, 0.0, 2.0):
        down = (circle(outliers) + np.array([0.0, aside, 0.0])) * np.array([1.0, -1.0, -1.0])
        below, above = (f"{share:.0%}" for share in (1.0 - outliers / 200, outliers / 200))
        doubt = (
            f"z is below -0.1 m in {below} of the positions and above 0.1 m in {above}: z may be down, but"
        )
        if aside < 0.0:
            doubt = doubt.replace(", but", ", or y up, but")
        assert up_axis_reason(down).startswith(doubt)


def test_a_flight_on_one_side_in_a_frame_whose_y_is_up_names_both_axes() -> None:
    one_side = y_up(circle() + np.array([0.0, 1.5, 0.5]))
    assert "100% of the positions and above 0.1 m in 0%: z may be down, or y up" in up_axis_reason(one_side)


def test_an_origin_above_the_floor_and_unknown_positions_raise_no_doubt() -> None:
    climbing = circle() + np.linspace(-2.0, 0.0, 200)[:, None] * np.array([0.0, 0.0, 1.0])
    assert up_axis_reason(climbing) == ""
    assert up_axis_reason(np.full((9, 2, 3), np.nan)) == ""


def test_identify_reports_of_a_bag_whose_y_is_up(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with BagWriter(tmp_path / "turned") as bag:
        for tick, place in enumerate(y_up(circle())):
            frame = MocapFrame(0.01 * tick, ("cf1",), place[None], np.full((1, 4), np.nan))
            bag.write_signal("/mocap", 10_000_000 * tick, frame)
    given = [str(tmp_path / "turned"), "--out", str(tmp_path / "model.q2q")]
    assert identify.main(given) == 1  # it has no reference
    output = " ".join(capsys.readouterr().err.split())  # wrapped where the terminal ends
    assert (
        "identify: flight turned: z is below -0.1 m in 46% of the positions and y in 0%: y may be up, but z "
        "must be" in output
    )


@NEEDS_DATA
def test_no_public_flight_is_doubted_and_most_are_with_y_up() -> None:
    files = sorted([*DATA.glob("nanobench/*.parquet"), *DATA.glob("neural_swarm/*.parquet")])
    flights = {file.stem: flight_table(read_columns(file)).vectors(POS) for file in files}
    assert [name for name, pos in flights.items() if up_axis_reason(pos)] == []
    found = sum(bool(up_axis_reason(y_up(pos))) for pos in flights.values())
    assert found >= 0.8 * len(flights) > 0  # 30 of 34: the others move to one side only
    assert all("z may be down" in up_axis_reason(pos * [1.0, -1.0, -1.0]) for pos in flights.values())
