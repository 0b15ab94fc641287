"""Tests of the scaling of a jet to another airframe by momentum theory."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from q2q_model.commands.scale_model import main
from q2q_model.downwash.interaction_model import pairs_at_rest
from q2q_model.downwash.jet import MOVING_LAW
from q2q_model.downwash.level_set import LevelSet, level_set
from q2q_model.downwash.scaled_jet import AIR_DENSITY, CRAZYFLIE, SCALING_STD, QuadrotorSize, scaled_jet
from q2q_model.geometry.zone import Cylinder
from q2q_model.model_files.model_file import ModelFile, load, save
from q2q_model.vehicle.constants import GRAVITY

TWICE = QuadrotorSize(mass=8.0 * CRAZYFLIE.mass, rotor_radius=2.0 * CRAZYFLIE.rotor_radius)
"""Twice as large in every direction."""


def test_the_induced_velocity_carries_the_weight() -> None:
    area = CRAZYFLIE.mass / CRAZYFLIE.disk_loading
    thrust = 2.0 * AIR_DENSITY * area * CRAZYFLIE.induced_velocity**2
    assert thrust == pytest.approx(CRAZYFLIE.mass * GRAVITY, rel=1e-12)


def test_a_jet_scaled_to_its_own_airframe_differs_in_its_doubt_alone() -> None:
    same = scaled_jet(MOVING_LAW, CRAZYFLIE, CRAZYFLIE)
    assert replace(same, relative_std=MOVING_LAW.relative_std) == MOVING_LAW
    assert same.relative_std > SCALING_STD


def test_vehicles_of_one_kind_feel_the_same_at_the_same_place_over_their_size() -> None:
    rel_pos = np.array([[0.0, 0.0, 0.4], [0.05, 0.02, 0.6], [0.1, 0.0, 0.3]])
    small = MOVING_LAW.acceleration(rel_pos, pairs_at_rest(rel_pos))
    large = scaled_jet(MOVING_LAW, CRAZYFLIE, TWICE).acceleration(2.0 * rel_pos, pairs_at_rest(rel_pos))
    np.testing.assert_allclose(large, small, rtol=1e-3, atol=1e-6)  # roles blend over a fixed height


def test_a_heavy_vehicle_pushes_a_light_one_by_the_ratio_of_their_disk_loadings() -> None:
    mixed = scaled_jet(MOVING_LAW, CRAZYFLIE, TWICE, below=CRAZYFLIE)
    assert TWICE.disk_loading == pytest.approx(2.0 * CRAZYFLIE.disk_loading, rel=1e-12)
    assert mixed.strength == pytest.approx(2.0 * MOVING_LAW.strength, rel=1e-12)
    assert mixed.travel_speed == pytest.approx(np.sqrt(2.0) * MOVING_LAW.travel_speed, rel=1e-12)


def test_an_airframe_that_cannot_be_is_refused() -> None:
    with pytest.raises(ValueError, match=r"QuadrotorSize\.rotor_radius = 0\.0; must be in \["):
        QuadrotorSize(rotor_radius=0.0)


def scale(model: Path | str, out: Path, *more: str) -> int:
    """Run the command for a vehicle of twice the size."""
    size = ["--mass", str(TWICE.mass), "--rotor-radius", str(TWICE.rotor_radius)]
    return main(["--model", str(model), *size, "--out", str(out), *more])


def test_the_command_writes_the_scaled_jet_and_its_zone(tmp_path: Path) -> None:
    known, out = tmp_path / "known.q2q", tmp_path / "large.q2q"
    save(known, ModelFile(MOVING_LAW, Cylinder(eps=0.1, d=0.8)))
    assert scale(known, out) == 0
    large = load(out)
    assert large.interaction == scaled_jet(MOVING_LAW, CRAZYFLIE, TWICE)
    assert large.zone == Cylinder(eps=0.2, d=1.6)
    assert large.gains is None
    assert large.residual is None
    save(known, ModelFile(MOVING_LAW, level_set(MOVING_LAW, 0.3)))
    assert scale(known, out, "--below-mass", "0.032", "--below-rotor-radius", "0.0225") == 0
    heavy = load(out)
    assert heavy.interaction == scaled_jet(MOVING_LAW, CRAZYFLIE, TWICE, CRAZYFLIE)
    assert isinstance(heavy.zone, LevelSet)
    assert heavy.zone.d > 1.6 * level_set(MOVING_LAW, 0.3).d


def test_what_cannot_be_scaled_is_refused_in_one_sentence(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out.q2q"
    assert scale("none", out) == 1
    assert (
        main(["--model", "moving_law", "--mass", "0.0001", "--rotor-radius", "0.02", "--out", str(out)]) == 1
    )
    said = capsys.readouterr().err.splitlines()
    assert "model none is of the class NoInteraction: only a Jet can be scaled" in said[0]
    assert "QuadrotorSize.mass = 0.0001; must be in [" in said[1]
    assert not out.exists()
