"""Attitude tracks against SciPy: body rates, unit length, sign, and both sides of the gates, by both ways."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from q2q_model.estimation.association.reacquisition import Table
from q2q_model.estimation.attitude.attitude_steps import (
    ATTITUDE,
    UNIT_TOLERANCE,
    AttitudeGateParams,
    follow_attitudes,
)
from q2q_model.estimation.attitude.attitude_tracks import AttitudeTracks
from q2q_model.geometry.rotations import quat_from_euler, quat_multiply
from q2q_model.signals.values import Array

PARAMS = AttitudeGateParams(
    turn_max=0.35, turn_rate_max=12.0, rate_filter_s=0.02, reacquire_s=0.3, flip_reacquire_s=1.5, coast_s=0.35
)
STEP = 0.01
N = 5
ABSENT = np.full(4, np.nan)


def tumbling(seed: int) -> tuple[Array, Array]:
    """Return attitudes (N, 4) and body rates (N, 3) [rad/s] about all axes."""
    generator = np.random.default_rng(seed)
    upright = Rotation.from_euler("zyx", generator.uniform(-1.0, 1.0, (N, 3)))
    return upright.as_quat(), generator.normal(0.0, 4.0, (N, 3))


def turned(quat: Array, rate: Array, seconds: float) -> Array:
    """Return attitudes after a body rate [rad/s] for some seconds."""
    return np.asarray((Rotation.from_quat(quat) * Rotation.from_rotvec(rate * seconds)).as_quat())


class Seen:
    """N tracks seen at 1 s: by the compiled way or, beside a vehicle never seen, by the general one."""

    def __init__(self, quat: Array, more: int) -> None:
        self._block, self._more = AttitudeTracks(PARAMS, N + more), more
        assert self.update(1.0, quat) == 0

    def update(self, t: float, measured: Array) -> int:
        """Take a tick of the N vehicles; return how many attitudes are rejected."""
        return self._block.update(t, np.concatenate([measured, np.tile(ABSENT, (self._more, 1))]))

    @property
    def quat(self) -> Array:
        """Return the attitudes, (N, 4)."""
        return self._block.quat[:N]

    @property
    def rate(self) -> Array:
        """Return the body rates [rad/s], (N, 3)."""
        return self._block.ang_vel_body[:N]


BOTH = pytest.mark.parametrize("more", [0, 1], ids=["compiled", "general"])


@BOTH
@pytest.mark.parametrize("seed", range(5))
def test_rates_are_scipys_behind_the_filter_and_attitudes_those_measured(more: int, seed: int) -> None:
    quat, rate = tumbling(seed)
    tracks, expected = Seen(quat, more), np.zeros((N, 3))
    scale = np.linspace(1.0 - 0.9 * UNIT_TOLERANCE, 1.0 + 0.9 * UNIT_TOLERANCE, N)[:, None]
    for k in range(1, 6):
        now = turned(quat, rate, k * STEP)
        sign = np.where(np.arange(N) % 2 == k % 2, 1.0, -1.0)[:, None]  # means nothing
        assert tracks.update(1.0 + k * STEP, sign * scale * now) == 0
        expected += STEP / (STEP + PARAMS.rate_filter_s) * (rate - expected)
        np.testing.assert_allclose(tracks.rate, expected, atol=1e-11)
        nearest = np.sign((now * quat).sum(1, keepdims=True))  # of two signs the one nearest before
        np.testing.assert_allclose(tracks.quat, nearest * now, atol=1e-14)


@BOTH
def test_an_absent_attitude_is_held_without_rate_and_its_turn_counts_from_when_it_was_seen(more: int) -> None:
    quat, rate = tumbling(9)
    tracks = Seen(quat, more)
    tracks.update(1.0 + STEP, turned(quat, rate, STEP))
    held, measured = tracks.quat, turned(quat, rate, 2 * STEP)
    measured[2] = ABSENT
    measured[3, 1] = np.nan  # no attitude either
    assert tracks.update(1.0 + 2 * STEP, measured) == 0
    assert tracks.quat[[2, 3]].tolist() == held[[2, 3]].tolist()
    assert tracks.rate[[2, 3]].tolist() == [[0.0] * 3] * 2
    assert tracks.rate[[0, 1, 4]].all()
    assert tracks.update(1.0 + 3 * STEP, turned(quat, rate, 3 * STEP)) == 0
    blend = 2 * STEP / (2 * STEP + PARAMS.rate_filter_s)  # from rest, over both steps
    np.testing.assert_allclose(tracks.rate[[2, 3]], blend * rate[[2, 3]], atol=1e-11)


@BOTH
@pytest.mark.parametrize("elapsed", [STEP, 0.1])
@pytest.mark.parametrize("seed", range(3))
def test_a_turn_passes_up_to_the_bound_and_not_beyond(more: int, elapsed: float, seed: int) -> None:
    quat, axis = tumbling(seed)
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    bound = PARAMS.turn_max + PARAMS.turn_rate_max * elapsed
    for turn, rejected in ((bound - 1e-6, 0), (bound + 1e-6, N)):
        for sign in (1.0, -1.0):
            assert Seen(quat, more).update(1.0 + elapsed, sign * turned(quat, axis, turn)) == rejected


@BOTH
def test_after_a_long_time_any_turn_that_ends_upright_passes_and_gives_no_rate(more: int) -> None:
    quat, _ = tumbling(0)
    about = quat_from_euler(0.0, 0.0, 0.999 * np.pi)  # world z: upright vehicles stay so
    tracks = Seen(quat, more)
    assert tracks.update(2.0, quat_multiply(np.broadcast_to(about, quat.shape), quat)) == 0
    assert not tracks.rate.any()


@BOTH
def test_a_turn_to_upside_down_passes_up_to_a_right_angle_only(more: int) -> None:
    quat, _ = tumbling(0)
    tilted = np.tile(quat_from_euler(np.deg2rad(60.0), 0.0, 0.0), (len(quat), 1))
    for turn, rejected in ((80.0, 0), (100.0, len(quat))):  # to 140 and 160 degrees
        over = np.tile(quat_from_euler(np.deg2rad(60.0 + turn), 0.0, 0.0), (len(quat), 1))
        assert Seen(tilted, more).update(2.0, over) == rejected


@BOTH
def test_who_is_accepted_upside_down_is_upright_again_at_the_first_such_attitude(more: int) -> None:
    quat, _ = tumbling(0)
    over = quat_multiply(quat_from_euler(np.pi, 0.0, 0.0), quat)
    tracks = Seen(quat, more)
    tracks.update(2.0, over)
    assert tracks.update(2.0 + PARAMS.flip_reacquire_s - 1e-6, over) == len(quat)
    assert tracks.update(2.0 + PARAMS.flip_reacquire_s, over) == 0
    np.testing.assert_allclose(np.abs((tracks.quat * over).sum(1)), 1.0, atol=1e-12)
    assert tracks.update(3.7, quat) == 0
    np.testing.assert_allclose(np.abs((tracks.quat * quat).sum(1)), 1.0, atol=1e-12)
    assert not tracks.rate.any()


@BOTH
@pytest.mark.parametrize("length", [1.0 - 1.02 * UNIT_TOLERANCE, 1.0 + 1.02 * UNIT_TOLERANCE, 0.0, 3.0])
def test_what_has_not_unit_length_is_absent(more: int, length: float) -> None:
    quat, rate = tumbling(4)
    tracks = Seen(quat, more)
    tracks.update(1.0 + STEP, turned(quat, rate, STEP))
    held = tracks.quat
    assert tracks.update(1.0 + 2 * STEP, length * quat) == 0
    assert tracks.quat.tolist() == held.tolist()
    assert not tracks.rate.any()


def at_rest(quat: Array, *, seen: bool = True, rejected_since: float = np.inf) -> Table:
    """Return tracks of which all but the last were seen at 1 s."""
    tracks = np.zeros(N, ATTITUDE)
    tracks["seen"], tracks["time"], tracks["rejected_since"], tracks["quat"] = True, 1.0, np.inf, quat
    tracks["seen"][-1], tracks["rejected_since"][-1] = seen, rejected_since
    return tracks


def taken(t: float, measured: Array, tracks: Table) -> bool:
    """Return whether the compiled way takes a tick; where not, no track has changed."""
    before = tracks.copy()
    took = follow_attitudes(t, measured, PARAMS, tracks)
    assert took or np.array_equal(tracks, before)
    return took


def test_the_compiled_way_takes_nominal_ticks_alone_and_changes_nothing_in_others() -> None:
    quat, rate = tumbling(5)
    soon, now = 1.0 + STEP, turned(quat, rate, STEP)
    assert taken(soon, now, at_rest(quat))
    assert not taken(soon, now, at_rest(quat, seen=False))
    assert not taken(soon, now, at_rest(quat, rejected_since=0.9))
    assert taken(1.0 + PARAMS.coast_s - 1e-6, quat, at_rest(quat))
    assert not taken(1.0 + PARAMS.coast_s + 1e-6, quat, at_rest(quat))
    assert taken(soon, np.tile(ABSENT, (N, 1)), at_rest(quat))
    wrong = now.copy()
    wrong[-1] *= 1.0 + 1.02 * UNIT_TOLERANCE
    assert not taken(soon, wrong, at_rest(quat))
    wrong[-1] = turned(
        quat[-1:], np.array([[0.0, 0.0, 1.0]]), PARAMS.turn_max + PARAMS.turn_rate_max * STEP + 1e-6
    )[0]
    assert not taken(soon, wrong, at_rest(quat))
