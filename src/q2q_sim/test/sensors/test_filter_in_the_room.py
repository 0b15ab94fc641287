"""Tests of the mocap filter and the batch rule with the simulated VICON, which reports what it injected."""

from dataclasses import dataclass

import numpy as np
import pytest
from resting_signals import resting_state

from q2q_model.estimation.mocap_filter import MocapFilter
from q2q_model.estimation.mocap_filter_params import MocapFilterParams
from q2q_model.flights.outliers import find_outliers
from q2q_model.signals.values import Array, Names, SwarmState, TrackStatus
from q2q_sim.sensors.vicon import Injected, Vicon
from q2q_sim.sensors.vicon_params import ViconParams

NAMES: Names = ("cf1", "cf2", "cf3")
TICK_S = 0.01
TICKS = 6000
"""A minute: some 200 of each event a vehicle."""
ROOM = ViconParams(
    pos_noise=0.15e-3,
    angle_noise=3e-3,
    outlier_rate=1.0,
    dropout_rate=0.2,
    flip_rate=0.2,
    swap_rate=0.2,
    stale_rate=0.1,
)


def _truth(tick: int) -> SwarmState:
    t = tick * TICK_S
    phase = np.array([0.0, 2.0, 4.0])
    pos = np.stack([np.sin(0.7 * t + phase), np.cos(0.9 * t + phase), 1.0 + 0.5 * phase / 2.0], axis=-1)
    vel = np.stack([0.7 * np.cos(0.7 * t + phase), -0.9 * np.sin(0.9 * t + phase), 0.0 * phase], axis=-1)
    return resting_state(t, NAMES, pos, vel=vel)


@dataclass(frozen=True, slots=True)
class Flown:
    """A flight through the filter: T ticks, n vehicles."""

    true_pos: Array
    """True positions [m], world, (T, n, 3)."""
    pos: Array
    """Filtered positions [m], world, (T, n, 3)."""
    tilt: Array
    """w of the filtered quaternions, (T, n)."""
    status: Array
    """TrackStatus, (T, n)."""
    flags: Array
    """Injected faults, (T, n)."""
    seen: Array
    """Positions in the frames [m], NaN where a vehicle is missing, (T, n, 3)."""

    @property
    def error(self) -> Array:
        """Return the distance of the filtered from the true positions [m], (T, n)."""
        return np.linalg.norm(self.pos - self.true_pos, axis=-1)


@pytest.fixture(scope="module")
def flown() -> Flown:
    vicon, block = Vicon(ROOM, 3, TICK_S, seed=1), MocapFilter(MocapFilterParams(), NAMES)
    truth = [_truth(tick) for tick in range(TICKS)]
    states, flags, seen = [], [], np.full((TICKS, 3, 3), np.nan)
    for tick, true in enumerate(truth):
        frame = vicon.observe(true)
        flags.append(vicon.injected.copy())
        for name, pos in zip(frame.names, frame.pos, strict=True):
            seen[tick, NAMES.index(name)] = pos
        states.append(block.update(frame))
    return Flown(
        true_pos=np.array([one.pos for one in truth]),
        pos=np.array([one.pos for one in states]),
        tilt=np.array([one.quat[:, 3] for one in states]),
        status=np.array([one.status for one in states]),
        flags=np.array(flags),
        seen=seen,
    )


def test_every_outlier_is_refused_and_good_samples_are_taken(flown: Flown):
    is_outlier = flown.flags & (Injected.OUTLIER | Injected.SWAP) == Injected.OUTLIER
    outliers = is_outlier & np.isfinite(flown.seen).all(axis=-1)
    assert outliers.sum() > 100
    assert np.all(flown.status[outliers] != TrackStatus.TRACKED)
    good = flown.flags == Injected.NOTHING
    assert np.mean(flown.status[good] != TrackStatus.TRACKED) <= 0.001  # what the project promises


def test_no_fault_moves_the_state_far_from_the_truth(flown: Flown):
    good = (flown.status == TrackStatus.TRACKED) & (flown.flags == Injected.NOTHING)
    assert flown.error[good].max() < 0.06  # the gate: 40 mm, and 3 sigma of a gap
    # coasting at constant velocity for up to 0.3 s where the acceleration is at most 0.9 m/s^2
    assert flown.error[flown.status == TrackStatus.COASTING].max() < 0.06


def test_no_flip_turns_a_vehicle_over(flown: Flown):
    assert (flown.flags & Injected.FLIP > 0).any()
    assert np.abs(flown.tilt).min() > np.cos(0.05)  # mrad of noise; a flip would give 0


def test_the_batch_rule_finds_outliers_and_swaps_and_leaves_the_rest(flown: Flown):
    found = find_outliers(TICK_S * np.arange(TICKS), flown.seen)
    seen = np.isfinite(flown.seen).all(axis=-1)
    moved = np.linalg.norm(flown.seen - flown.true_pos, axis=-1)
    wrong = seen & (flown.flags & (Injected.OUTLIER | Injected.SWAP) > 0) & (moved > 0.05)
    assert found[wrong].mean() >= 0.99  # what the project promises
    assert found[seen & (flown.flags == Injected.NOTHING)].mean() <= 0.001
