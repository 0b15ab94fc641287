"""The area growth of the benchmarks: its power law fits in closed form, and its figures show every block."""

from pathlib import Path

import numpy as np
import pytest
from scipy.stats import linregress, t

from cost_growth.growth_figure import TIME, growth_figure
from cost_growth.held_arrays import array_bytes
from cost_growth.points import WHOLE, Curve, Point, measured_curves
from cost_growth.power_law import power_law
from growth import SIZES, draw, message_bytes
from q2q_model.signals.values import MocapFrame, SwarmState

ALL = np.array(SIZES, dtype=float)
SMALL = (2, 4, 8)


def test_a_power_law_is_found_exactly_and_is_straight():
    law = power_law(ALL, 3.0 * ALL**1.5)
    assert law.below.value == pytest.approx(1.5, abs=1e-12)
    assert law.below.high - law.below.low < 1e-9
    assert not law.bent
    assert law.cost(np.array([1e4])) == pytest.approx([3e6])


def test_a_bend_is_found_at_its_size_with_both_slopes():
    law = power_law(ALL, 50.0 * np.where(ALL < 100, (ALL / 100) ** 0.2, (ALL / 100) ** 2.0))
    assert law.bent
    assert law.origin == 100.0
    assert (law.below.value, law.above.value) == pytest.approx((0.2, 2.0), abs=1e-12)
    assert law.cost(np.array([2.0, 1e4])) == pytest.approx([50.0 * 0.02**0.2, 50.0 * 100.0**2])


def test_slope_and_interval_of_noisy_costs_are_those_of_linear_regression():
    noise = np.random.default_rng(0).normal(0.0, 0.05, ALL.size)
    law = power_law(ALL, np.exp(noise) * ALL)
    other = linregress(np.log(ALL), np.log(ALL) + noise)
    half = t.ppf(0.975, ALL.size - 2) * other.stderr
    assert not law.bent
    assert law.below.value == pytest.approx(other.slope)
    assert law.below.high - law.below.value == pytest.approx(half)


def test_the_interval_of_a_cost_covers_the_truth_in_95_of_100_fits():
    rng, held = np.random.default_rng(1), 0
    for _ in range(400):
        low, high = power_law(ALL[:5], np.exp(rng.normal(0.0, 0.1, 5)) * ALL[:5]).cost_interval(1e4)
        held += low <= 1e4 <= high
    assert held / 400 == pytest.approx(0.95, abs=0.033)  # three deviations of a share of 400


def test_two_sizes_make_no_slope():
    with pytest.raises(ValueError, match="2 sizes"):
        power_law(np.array([1.0, 2.0]), np.array([1.0, 2.0]))


def test_an_array_counts_once_and_a_view_as_its_owner():
    class Keeper:
        def __init__(self) -> None:
            self.table = np.zeros(10)
            self.views = [self.table[2:4], {"same": self.table}]

    assert array_bytes(Keeper()) == 80


def test_a_messages_bytes_grow_by_its_numbers_and_names():
    # position, velocity, orientation, rate and age are 14 doubles, the status a byte
    grown = message_bytes(SwarmState, 200) - message_bytes(SwarmState, 100)
    assert grown == pytest.approx(100 * (14 * 8 + 1 + 4 + 8), abs=16)  # length and padded text of a name
    assert message_bytes(MocapFrame, 10_000) > 10_000 * 7 * 8


@pytest.fixture(scope="module")
def curves() -> list[Curve]:
    return measured_curves(SMALL, most_ticks=5)


def test_every_block_has_a_point_and_a_reference_at_every_size(curves: list[Curve]):
    assert WHOLE in {curve.block for curve in curves}
    for curve in curves:
        assert [point.vehicles for point in curve.points] == list(SMALL)
        for point in curve.points:
            assert 0.0 < point.least <= point.seconds <= point.most
            assert point.reference > 0.0


def test_figures_of_time_and_memory_are_drawn(curves: list[Curve], tmp_path: Path):
    paths = draw(curves[:2], tmp_path)
    assert [path.name for path in paths] == ["growth_time.png", "growth_memory.png"]
    assert all(path.stat().st_size < 300_000 for path in paths)


def test_the_lowest_panel_of_every_column_has_the_axis_and_its_name():
    points = tuple(Point(n, 1e-6 * n, 1e-6 * n, 1e-6 * n, 1e-5 * n, 8 * n, 100) for n in (2, 4, 8))
    figure = growth_figure([Curve(f"block {k}", "reference", points) for k in range(4)], TIME)
    shown = [axes for axes in figure.axes if axes.axison]
    named = [axes.get_xlabel() == "vehicles" for axes in shown]
    numbered = [axes.xaxis.get_tick_params()["labelbottom"] for axes in shown]
    assert named == numbered == [False, True, True, True]


def test_a_filter_holds_memory_in_proportion_to_its_vehicles(curves: list[Curve]):
    (curve,) = [one for one in curves if one.block == "mocap filter"]
    held = np.array([point.held for point in curve.points])
    assert held[1:] / held[:-1] == pytest.approx(2.0, rel=0.1)  # few arrays are not of vehicles


def test_a_curve_reports_the_laws_of_time_and_memory():
    points = tuple(Point(n, 1e-6 * n, 1e-6 * n, 1e-6 * n, 1e-5 * n, 8 * n * n, 100) for n in (2, 4, 8))
    curve = Curve("block", "reference", points)
    assert curve.time_law.above.value == pytest.approx(1.0)
    assert curve.memory_law.above.value == pytest.approx(2.0)
