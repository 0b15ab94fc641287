"""Tests of the zones' signed distances against closed forms and brute force."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from q2q_model.downwash.interaction_model import pairs_at_rest
from q2q_model.downwash.jet import PAPER_LAW, Jet
from q2q_model.downwash.level_set import STEP, LevelSet, level_set, push_at_range
from q2q_model.geometry.zone import Cylinder, Ellipsoid, Zone

coordinate = st.floats(-3.0, 3.0)
LEVEL = level_set(PAPER_LAW, 0.1)
ZONES: list[Zone] = [Cylinder(), Ellipsoid(0.2, 1.5), LEVEL]


def test_an_ellipsoid_with_equal_axes_is_a_ball():
    rel_pos = np.random.default_rng(6).normal(size=(50, 3))
    expected = np.linalg.norm(rel_pos, axis=-1) - 0.7
    np.testing.assert_allclose(Ellipsoid(0.7, 0.7).signed_distance(rel_pos), expected, atol=1e-9)


def test_an_ellipsoids_distance_is_that_to_the_nearest_of_many_surface_points():
    zone = Ellipsoid(0.12, 1.9)
    angle = np.linspace(0.0, 2.0 * np.pi, 200_001)
    surface = np.stack([0.12 * np.cos(angle), 1.9 * np.sin(angle)], axis=-1)
    for point in np.random.default_rng(7).normal(size=(20, 2)) * [0.2, 1.5]:
        brute = np.min(np.hypot(*(surface - point).T))
        inside = (point[0] / 0.12) ** 2 + (point[1] / 1.9) ** 2 < 1.0
        found = zone.signed_distance(np.array([point[0], 0.0, point[1]]))
        assert found == pytest.approx(-brute if inside else brute, abs=6e-5)  # half a surface step


def test_an_ellipsoids_centre_is_its_shorter_half_axis_deep():
    assert Ellipsoid(0.12, 1.9).signed_distance(np.zeros(3)) == pytest.approx(
        -0.12, abs=1e-7
    )  # nudged off the axis


def test_the_ellipsoid_around_a_cylinder_touches_its_rim():
    rim = np.array([0.1, 0.0, 1.1])
    assert Ellipsoid.around(Cylinder()).signed_distance(rim) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("zone", ZONES)
def test_a_zone_is_symmetric_and_turns_about_the_vertical(zone: Zone):
    rel_pos = np.random.default_rng(8).normal(size=(100, 3)) * 0.5
    turned = rel_pos[:, [1, 0, 2]] * [-1.0, 1.0, 1.0]
    np.testing.assert_allclose(zone.signed_distance(-rel_pos), zone.signed_distance(rel_pos), atol=1e-9)
    np.testing.assert_allclose(zone.signed_distance(turned), zone.signed_distance(rel_pos), atol=1e-9)


@pytest.mark.parametrize("zone", ZONES)
@settings(deadline=None)
@given(st.tuples(coordinate, coordinate, coordinate), st.tuples(coordinate, coordinate, coordinate))
def test_a_signed_distance_changes_no_faster_than_the_place(
    zone: Zone, a: tuple[float, ...], b: tuple[float, ...]
):
    first, second = np.array(a), np.array(b)
    change = abs(float(zone.signed_distance(first) - zone.signed_distance(second)))
    assert change <= np.linalg.norm(first - second) + STEP  # the table is good to half a step at each end


def test_a_level_sets_boundary_is_where_the_downwash_is_the_threshold():
    gap = np.linspace(0.15, 0.9, 16)
    width = PAPER_LAW.width + PAPER_LAW.spread * gap
    axis = np.stack([0 * gap, 0 * gap, gap], axis=-1)
    peak = PAPER_LAW.push(axis, pairs_at_rest(axis))
    across = width * np.sqrt(2.0 * np.log(peak / 0.1))  # closed form of the Gaussian
    on_it = np.stack([across, 0.0 * gap, gap], axis=-1)
    np.testing.assert_allclose(LEVEL.signed_distance(on_it), 0.0, atol=0.5 * STEP)
    assert (LEVEL.signed_distance(on_it * [0.8, 1.0, 1.0]) < 0.0).all()
    assert (LEVEL.signed_distance(on_it * [1.2, 1.0, 1.0]) > 0.0).all()
    height = 0.83 * np.sqrt(0.392 / 0.1) - 0.33  # of the power law on the axis
    assert pytest.approx(height, abs=STEP) == LEVEL.d


@pytest.mark.parametrize("reach", [0.35, 0.7, 1.1, 1.2, 1.38, 1.4, 2.76, 3.0])
def test_the_downwash_at_the_end_of_a_range_is_that_on_the_axis_there(reach: float) -> None:
    """35 steps of 0.01 are above 0.35, 110 of them below 1.1 in float64."""
    law = Jet(decay="exponential", range=reach)
    end = np.array([0.0, 0.0, reach])
    on_axis = float(law.push(end, pairs_at_rest(end)))
    assert push_at_range(law) == pytest.approx(on_axis, rel=STEP)  # a step before the end it is 1 % more


@pytest.mark.parametrize("reach", [0.35, 0.5698, 0.7, 1.1, 1.1392, 1.1999])
def test_a_level_set_contains_the_downwash_up_to_the_end_of_a_range(reach: float) -> None:
    """35 steps of 0.01 are above 0.35 in float64; to half a step of the table elsewhere."""
    law = Jet(strength=4.0, decay="exponential", width=0.1, spread=0.25, range=reach)
    zone = level_set(law, 0.2)
    across, gap = np.meshgrid(np.linspace(0.0, 0.8, 401), np.linspace(reach - 0.02, reach, 41))
    rel_pos = np.stack([across, 0.0 * gap, gap], axis=-1)
    pushed = np.abs(law.acceleration(rel_pos, pairs_at_rest(rel_pos))[..., 2]) >= zone.threshold
    assert zone.signed_distance(rel_pos)[pushed].max() < 0.5 * STEP
    assert zone.signed_distance(rel_pos)[pushed & (across < 0.05)].max() < 0.0  # below the middle
    assert reach < zone.d < reach + 2.0 * STEP + 1e-9


def test_beyond_its_table_a_level_set_never_claims_more_than_the_true_distance():
    far = np.array([[4.0, 0.0, 0.5], [0.0, 3.0, 6.0], [2.0, 2.0, 9.0]])
    across, gap = np.hypot(far[:, 0], far[:, 1]), far[:, 2]
    inside = np.argwhere(LEVEL.table < 0.0) * STEP
    true = [np.hypot(*(inside - [a, g]).T).min() for a, g in zip(across, gap, strict=True)]
    claimed = LEVEL.signed_distance(far)
    assert (claimed <= np.array(true) + STEP).all()
    assert (claimed > 0.5 * np.array(true)).all()


def test_a_threshold_above_the_downwashs_peak_is_refused():
    with pytest.raises(ValueError, match=r"must be below the downwash's peak, 0\.\d"):
        level_set(Jet(strength=0.1), 5.0)


@pytest.mark.parametrize("zone", [Cylinder, Ellipsoid])
@pytest.mark.parametrize("size", [0.0, -0.1, 100.0, np.nan])
def test_a_zone_of_no_size_is_refused(zone: type[Cylinder | Ellipsoid], size: float) -> None:
    with pytest.raises(ValueError, match=rf"{zone.__name__}\.d = {size}; must be above 0 and below 100 m"):
        zone(0.1, size)
    with pytest.raises(ValueError, match=rf"{zone.__name__}\.eps = {size}; must be above 0 and below 100 m"):
        zone(size, 0.1)


def test_a_level_set_knows_its_own_extent():
    assert isinstance(LEVEL, LevelSet)
    assert 0.1 < LEVEL.eps < 0.3
