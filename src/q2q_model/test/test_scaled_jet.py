"""Prove the scaling of a jet to another airframe by momentum theory."""

from dataclasses import replace

import numpy as np
import pytest

from q2q_model.downwash.interaction_model import at_rest
from q2q_model.downwash.jet import MOVING_LAW
from q2q_model.downwash.scaled_jet import AIR_DENSITY, CRAZYFLIE, DOUBT, QuadrotorSize, scaled_jet
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
    assert same.relative_std > DOUBT


def test_vehicles_of_one_kind_feel_the_same_at_the_same_place_over_their_size() -> None:
    rel_pos = np.array([[0.0, 0.0, 0.4], [0.05, 0.02, 0.6], [0.1, 0.0, 0.3]])
    small = MOVING_LAW.acceleration(rel_pos, at_rest(rel_pos))
    large = scaled_jet(MOVING_LAW, CRAZYFLIE, TWICE).acceleration(2.0 * rel_pos, at_rest(rel_pos))
    np.testing.assert_allclose(large, small, rtol=1e-3, atol=1e-6)  # roles blend over a fixed height


def test_a_heavy_vehicle_pushes_a_light_one_by_the_ratio_of_their_disk_loadings() -> None:
    mixed = scaled_jet(MOVING_LAW, CRAZYFLIE, TWICE, below=CRAZYFLIE)
    assert TWICE.disk_loading == pytest.approx(2.0 * CRAZYFLIE.disk_loading, rel=1e-12)
    assert mixed.strength == pytest.approx(2.0 * MOVING_LAW.strength, rel=1e-12)
    assert mixed.travel_speed == pytest.approx(np.sqrt(2.0) * MOVING_LAW.travel_speed, rel=1e-12)


def test_an_airframe_that_cannot_be_is_refused() -> None:
    with pytest.raises(ValueError, match=r"QuadrotorSize\.rotor_radius = 0\.0: allowed is"):
        QuadrotorSize(rotor_radius=0.0)
