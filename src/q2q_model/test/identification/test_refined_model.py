"""Models scaled by a gain, and what their files hold."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from q2q_model.downwash.interaction_model import pairs_at_rest
from q2q_model.downwash.jet import MOVING_LAW, Jet
from q2q_model.downwash.level_set import LevelSet, level_set, peak_downwash
from q2q_model.downwash.no_interaction import NoInteraction
from q2q_model.geometry.zone import Cylinder, Ellipsoid
from q2q_model.identification.networks.gradient import unpack
from q2q_model.identification.online_refinement import OnlineRefinement
from q2q_model.identification.refined_model import (
    UnscalableModelError,
    largest_gain,
    refined_file,
    scale_downwash,
)
from q2q_model.model_files.model_bounds import check_model
from q2q_model.model_files.model_file import Fit, ModelFile, load, save
from q2q_model.model_files.model_names import ModelFileError
from q2q_model.vehicle.constants import CRAZYFLIE_2_1

PEAK = peak_downwash(MOVING_LAW)


def test_every_kind_of_model_scales():
    rel_pos = np.array([[0.03, 0.0, 0.4], [0.0, 0.02, -0.5]])
    networks = unpack(np.random.default_rng(14).standard_normal(322), 0.1, 1.1)
    for law in (Jet(carried=1.0, travel_speed=3.0), networks, NoInteraction()):
        once, twice = (
            one.acceleration(rel_pos, pairs_at_rest(rel_pos)) for one in (law, scale_downwash(law, 2.0))
        )
        np.testing.assert_allclose(twice, 2.0 * once, rtol=1e-12)


def test_a_model_of_another_class_is_refused_before_the_flight() -> None:
    column = type("Column", (), {})()
    with pytest.raises(UnscalableModelError, match="a model of the class Column has no gain that can be"):
        OnlineRefinement(column, CRAZYFLIE_2_1)


@pytest.mark.parametrize(("strength", "most"), [(2.0, 2.0), (12.0, 20.0 / 12.0), (-18.0, 20.0 / 18.0)])
def test_a_gain_keeps_the_strength_of_a_jet_within_its_bounds(strength: float, most: float) -> None:
    flat = replace(MOVING_LAW, strength=strength, decay="exponential", decay_rate=0.0)
    assert largest_gain(flat, 2.0) == pytest.approx(most, abs=1e-3)
    check_model(scale_downwash(flat, largest_gain(flat, 2.0)))


def test_a_gain_keeps_the_downwash_of_a_jet_within_five_g() -> None:
    near = replace(MOVING_LAW, strength=10.0, reference_gap=0.14, decay="exponential", decay_rate=-1.0)
    check_model(near)
    gain = largest_gain(near, 2.0)
    assert 1.0 < gain < 2.0
    check_model(scale_downwash(near, gain))
    with pytest.raises(ValueError, match="5 g"):
        check_model(scale_downwash(near, 1.01 * gain))


@pytest.mark.parametrize(("gain", "kept"), [(0.5, False), (1.5, True)])
def test_a_refined_file_can_be_loaded_whatever_its_zone(tmp_path: Path, gain: float, kept: bool) -> None:
    """Half of a downwash never reaches 0.6 of its peak."""
    base = ModelFile(MOVING_LAW, level_set(MOVING_LAW, 0.6 * PEAK), fit=Fit("jet", ("one",), digests=("ab",)))
    save(tmp_path / "refined.q2q", refined_file(base, scale_downwash(MOVING_LAW, gain), gain))
    found = load(tmp_path / "refined.q2q")
    assert isinstance(found.zone, LevelSet if kept else Cylinder)
    assert found.fit == Fit(f"jet, times {gain:.3f} in flight", ("one",), digests=("ab",))


def test_a_file_that_load_would_refuse_is_not_saved(tmp_path: Path) -> None:
    base = ModelFile(MOVING_LAW, level_set(MOVING_LAW, 0.6 * PEAK))
    path = tmp_path / "refined.q2q"
    with pytest.raises(ModelFileError, match="zone threshold"):
        save(path, replace(base, interaction=scale_downwash(MOVING_LAW, 0.5)))
    assert not path.exists()


def test_a_zone_of_distances_stays() -> None:
    base = ModelFile(MOVING_LAW, Ellipsoid(0.2, 0.9))
    assert refined_file(base, scale_downwash(MOVING_LAW, 0.5), 0.5).zone == base.zone
