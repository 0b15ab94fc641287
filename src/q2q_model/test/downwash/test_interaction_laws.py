"""Tests of the interaction laws: equations, signs, and agreement with each other."""

from dataclasses import replace

import numpy as np
import pytest
from random_networks import networks

from q2q_model.downwash.envelope_network import EnvelopeNetwork, Network
from q2q_model.downwash.interaction_model import InteractionModel, PairMotion, pairs_at_rest
from q2q_model.downwash.jet import MEASURED_LAW, PAPER_LAW, Jet
from q2q_model.downwash.no_interaction import NoInteraction
from q2q_model.downwash.roles import lower_share, smooth_gap

ABOVE = np.array([0.0, 0.0, 0.5])
LEVEL = pairs_at_rest(ABOVE)
ROUNDING = 1e-12
CARRYING = replace(MEASURED_LAW, carried=1.0, relative_std=0.25)
LAWS: list[InteractionModel] = [NoInteraction(), PAPER_LAW, MEASURED_LAW, CARRYING, networks()]


def test_a_source_above_pushes_down_and_the_upper_vehicle_is_pushed_up_a_fifth_by_the_paper_law():
    below = PAPER_LAW.acceleration(np.array([0.0, 0.0, 0.5]), LEVEL)
    above = PAPER_LAW.acceleration(np.array([0.0, 0.0, -0.5]), LEVEL)
    np.testing.assert_allclose(below, [0.0, 0.0, -0.392], atol=ROUNDING)  # A at half a metre
    np.testing.assert_allclose(above, [0.0, 0.0, 0.2 * 0.392], atol=ROUNDING)


def test_the_paper_law_is_the_formula_of_its_reproduction():
    rel_pos = np.array([0.05, -0.03, 0.8])
    dxy2, dz = 0.05**2 + 0.03**2, 0.8
    by_hand = -0.392 * ((0.33 + 0.5) / (0.33 + dz)) ** 2 * np.exp(-dxy2 / (2 * (0.06 + 0.08 * dz) ** 2))
    assert PAPER_LAW.acceleration(rel_pos, LEVEL)[2] == pytest.approx(by_hand, rel=ROUNDING)


def test_the_measured_law_is_its_formula_and_arrives_late():
    rel_pos = np.array([0.03, 0.04, 0.6])
    by_hand = -2.5 * np.exp(-0.95 * 0.2) * np.exp(-(0.05**2) / (2 * 0.054**2))
    assert MEASURED_LAW.acceleration(rel_pos, LEVEL)[2] == pytest.approx(by_hand, rel=ROUNDING)
    assert MEASURED_LAW.delay(rel_pos) == pytest.approx(0.6 / 7.5)
    assert MEASURED_LAW.delay(-rel_pos) == 0.0


def test_the_network_is_its_matrix_formula_under_the_envelope():
    law = networks()
    rel_pos, across, gap = np.array([0.06, 0.08, 0.5]), 0.1, 0.5
    f = law.lower
    hidden = [
        np.tanh(w[0] * across + w[1] * gap + b) for w, b in zip(f.hidden_weights, f.hidden_bias, strict=True)
    ]
    by_hand = (
        np.exp(-0.5) * np.exp(-(0.5**2) / (2 * 1.1**2)) * (np.dot(hidden, f.output_weights) + f.output_bias)
    )
    assert law.acceleration(rel_pos, LEVEL)[2] == pytest.approx(
        by_hand, rel=1e-9
    )  # share at 0.5 m: 1 - 3e-15


@pytest.mark.parametrize("law", LAWS)
def test_a_law_is_negligible_beyond_its_reach_sideways(law: InteractionModel):
    edge = law.reach.horizontal
    near, far = np.array([0.0, 0.0, 0.5]), np.array([edge, 0.0, 0.5])
    ratio = np.abs(law.acceleration(far, LEVEL)[2]) / max(np.abs(law.acceleration(near, LEVEL)[2]), 1e-9)
    assert ratio < 2e-3  # envelope 1e-4, times the change of f between the two places


@pytest.mark.parametrize("law", LAWS)
def test_a_law_has_no_jump_where_the_vehicles_change_roles(law: InteractionModel):
    dz = np.linspace(-0.2, 0.2, 4001)
    rel_pos = np.stack([0.02 + 0.0 * dz, 0.0 * dz, dz], axis=-1)
    eta = law.acceleration(rel_pos, pairs_at_rest(rel_pos))[:, 2]
    largest = np.abs(eta).max() + 1e-9
    assert np.abs(np.diff(eta)).max() < 0.01 * largest  # a jump of roles would be of order 1
    assert np.abs(np.diff(eta, 2)).max() < 1e-3 * largest  # nor a corner


@pytest.mark.parametrize("law", LAWS)
def test_a_batch_of_pairs_is_the_same_as_a_loop(law: InteractionModel):
    rng = np.random.default_rng(5)
    rel_pos, vel, axis = rng.normal(size=(3, 3, 4, 3)) * 0.3
    axis[..., 2] = 1.0
    everyone = PairMotion(vel, axis, -vel)
    batch = law.acceleration(rel_pos, everyone), law.delay(rel_pos), law.deviation(rel_pos, everyone)
    for k in np.ndindex(3, 4):
        one = PairMotion(vel[k], axis[k], -vel[k])
        alone = law.acceleration(rel_pos[k], one), law.delay(rel_pos[k]), law.deviation(rel_pos[k], one)
        for whole, single in zip(batch, alone, strict=True):
            np.testing.assert_allclose(whole[k], single, rtol=1e-13)  # numpy may sum in another order


def test_the_roles_share_out_to_one_and_the_gap_is_the_height_difference_away_from_zero():
    dz = np.linspace(-1.0, 1.0, 101)
    np.testing.assert_allclose(lower_share(dz) + lower_share(-dz), 1.0, atol=ROUNDING)
    far = np.abs(dz) > 0.2
    np.testing.assert_allclose(smooth_gap(dz)[far], np.abs(dz)[far], rtol=1e-5)


def test_zero_distance_gives_a_finite_push():
    for law in LAWS:
        assert np.isfinite(law.acceleration(np.zeros(3), LEVEL)).all()


def test_a_parameter_out_of_bounds_is_refused_by_name():
    with pytest.raises(ValueError, match=r"Jet\.width = -0\.1"):
        Jet(width=-0.1)
    with pytest.raises(ValueError, match=r"must be one of power, exponential"):
        Jet(decay="linear")
    with pytest.raises(ValueError, match=r"EnvelopeNetwork\.eps = 0\.0"):
        EnvelopeNetwork(networks().lower, networks().upper, eps=0.0)
    with pytest.raises(ValueError, match=r"hidden weights \(2, 2\)"):
        Network(np.zeros((3, 2)), np.zeros(2), np.zeros(2), 0.0)


def test_a_source_leaning_to_x_aims_its_downwash_to_minus_x():
    """Body z leans to +x by 0.2, so the air goes to -x: 0.1 m aside after half a metre."""
    leaning = replace(LEVEL, source_axis=np.array([0.2, 0.0, 1.0]))
    hit = CARRYING.acceleration(np.array([0.1, 0.0, 0.5]), leaning)  # source 0.1 m ahead in x
    straight = CARRYING.acceleration(ABOVE, LEVEL)
    np.testing.assert_allclose(hit, straight, rtol=1e-12)
    assert abs(CARRYING.acceleration(ABOVE, leaning)[2]) < 0.3 * abs(straight[2])


def test_air_thrown_from_a_moving_source_moves_on_with_it():
    """With c = 1 at steady speed the downwash stays under its source: retarded place plus v tau."""
    vel = np.array([0.8, -0.4, 0.0])
    tau = 0.5 / MEASURED_LAW.travel_speed
    moving = replace(LEVEL, source_vel=vel)
    under = CARRYING.acceleration(ABOVE - vel * tau, moving)
    np.testing.assert_allclose(under, CARRYING.acceleration(ABOVE, LEVEL), rtol=1e-12)


def test_an_upside_down_source_throws_no_downwash_to_infinity():
    tumbled = replace(LEVEL, source_axis=np.array([1.0, 0.0, -0.1]))
    assert np.isfinite(CARRYING.acceleration(ABOVE, tumbled)).all()


def test_a_climbing_vehicle_meets_the_air_faster_and_one_that_sinks_with_it_feels_nothing():
    still = CARRYING.acceleration(ABOVE, LEVEL)[2]
    climbing = replace(LEVEL, vel=np.array([0.0, 0.0, 0.75]))  # a tenth of the air's 7.5 m/s
    assert CARRYING.acceleration(ABOVE, climbing)[2] == pytest.approx(1.1 * still)
    sinking = replace(LEVEL, vel=np.array([0.0, 0.0, -9.0]))
    assert CARRYING.acceleration(ABOVE, sinking)[2] == 0.0
    assert MEASURED_LAW.acceleration(ABOVE, climbing)[2] == MEASURED_LAW.acceleration(ABOVE, LEVEL)[2]
