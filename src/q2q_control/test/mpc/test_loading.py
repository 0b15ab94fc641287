"""A source that carries downwash of its own throws more air: the horizon may count that."""

from dataclasses import replace

import numpy as np
from resting_signals import resting_setpoint, resting_state

from q2q_control.inputs.alignment import align
from q2q_control.mpc.neighbours.constant_velocity import at_constant_velocity
from q2q_control.mpc.prediction.downwash_horizon import GradientRule, predict_downwash
from q2q_control.mpc.prediction.downwash_horizon_kernel import Tracks
from q2q_control.mpc.prediction.vehicle_tracks import Future, VehicleTracks
from q2q_model.downwash.interaction_model import pairs_at_rest
from q2q_model.downwash.jet import PAPER_LAW
from q2q_model.vehicle.constants import GRAVITY

PAIR = ("cf1", "cf2")
STAGES = 4


def tracks_of(loading: float, climb_acc: float) -> Tracks:
    """Return the tracks of a hovering pair whose upper vehicle accelerates upwards by `climb_acc` [m/s^2]."""
    pos = np.array([[0.0, 0.0, 1.0], [0.03, 0.0, 1.5]])
    state = resting_state(0.0, PAIR, pos)
    setpoint = resting_setpoint(0.0, PAIR, pos)
    inputs = np.zeros((2, STAGES, 3))
    inputs[1, :, 2] = climb_acc
    times = 0.05 * np.arange(STAGES + 1)
    path = np.repeat(pos[:, None], STAGES + 1, axis=1)
    future = Future(times, path, inputs)
    others = at_constant_velocity(state, PAIR, times)
    return VehicleTracks(span=0.0, loading=loading).tracks(align(state, setpoint, None), future, others)


def test_a_downwash_grows_with_its_sources_thrust_as_far_as_the_loading_says():
    rule = GradientRule((2,), 100.0)
    paper, loaded = (predict_downwash(PAPER_LAW, tracks_of(share, 2.0), rule) for share in (0.0, 0.5))
    growth = 1.0 + 0.5 * 2.0 / GRAVITY  # half of what the thrust exceeds the weight by
    assert paper.eta[0, 0, 2] < -0.1
    assert np.allclose(loaded.eta[0], growth * paper.eta[0], rtol=1e-12)
    assert np.allclose(loaded.eta[1], paper.eta[1], rtol=1e-12)  # the lower one hovers
    feels = int(np.flatnonzero(paper.i == 0)[0])
    assert np.allclose(loaded.gradient[feels], growth * paper.gradient[feels], rtol=1e-12)


def test_hovering_sources_have_the_downwashs_of_the_law_whatever_the_loading():
    rule = GradientRule((2,), 100.0)
    paper, loaded = (predict_downwash(PAPER_LAW, tracks_of(share, 0.0), rule) for share in (0.0, 1.0))
    assert np.allclose(loaded.eta, paper.eta, rtol=1e-12)


def test_the_horizons_lowest_vehicle_meets_what_the_middle_one_leaves_of_the_top_ones_jet():
    pos = np.repeat(np.array([[[0.0, 0.0, 1.0], [0.0, 0.0, 1.5], [0.0, 0.0, 2.1]]]), STAGES + 1, axis=0)
    level, weight = np.tile([0.0, 0.0, 1.0], (3, STAGES, 1)), np.ones((3, STAGES))
    tracks = Tracks(0.05 * np.arange(STAGES + 1), pos, level, weight, first=0)
    rule, taking = GradientRule((2,), 100.0), replace(PAPER_LAW, absorption=1.5)
    paper, left = (predict_downwash(law, tracks, rule) for law in (PAPER_LAW, taking))
    rel_pos = pos[0, 2] - pos[0, :2]
    on_low, on_middle = PAPER_LAW.acceleration(rel_pos, pairs_at_rest(rel_pos))[:, 2]  # by the top one alone
    taken = 1.5 * on_middle / GRAVITY * on_low
    assert taken > 0.005
    assert np.allclose(left.eta[0, :, 2], paper.eta[0, :, 2] + taken, rtol=1e-12)
    assert np.allclose(left.eta[2], paper.eta[2], rtol=1e-12)
