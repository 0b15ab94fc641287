"""Positions that estimators give in replays of a recorded motion.

| estimator | what it is |
|---|---|
| filter | the mocap filter of q2q; it knows no inertial sensors |
| stock | the firmware's filter, poses as they were captured, the firmware's parameters |
| fed | the same behind the mocap filter, as `radio` feeds it: poses moved on by the delay, its POSE_STD |
| all axes | the same, with all axes of the accelerometer (a build option), 3 mm and 0.3 rad |
| recorded | what the vehicle itself estimated in the recorded flight, where the recording has it |

Poses reach the vehicle DELAY ticks late. Of each sample an estimate is made that has not seen it: the
filter's by its velocity from the tick before, or as it coasts; the firmware's because poses are late.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from q2q_control.radio.link.firmware_params import POSE_STD
from q2q_model.estimation.mocap_filter import MocapFilter
from q2q_model.estimation.mocap_filter_params import MocapFilterParams
from q2q_model.geometry.pose_ahead import extrapolate_pose
from q2q_model.signals.values import Array, Mask, MocapFrame, TrackStatus
from q2q_sim.experiments.estimators.recorded_motion import RecordedMotion
from q2q_sim.firmware.estimator import DT
from q2q_sim.firmware.extended_kalman import GENERAL_PURPOSE, ExtendedKalman, ExtendedKalmanParams
from q2q_sim.random_streams import stream
from q2q_sim.sensors.imu import ImuParams

DELAY = 2
"""Ticks from camera to the vehicle's estimate."""
VIBRATING = ImuParams(acc_noise=0.2, acc_bias=0.1, gyro_noise=0.02, gyro_bias=0.005)
"""Errors of the sensors in flight, means over 10 ms. Accelerometer: noise as measured in flight
(q2q_model.downwash.correction.residual_process), bias between the 0.03 of z and the 0.14 of x and y in logs
of Neural-Swarm2 (T-RO 2021). Gyroscope: the bias of the `real` room, and ten times its noise for vibration,
which is assumed."""
FED = ExtendedKalmanParams(pos_std=POSE_STD["locSrv.extPosStdDev"], quat_std=POSE_STD["locSrv.extQuatStdDev"])
"""As `radio` sets them."""
ALL_AXES = replace(GENERAL_PURPOSE, pos_std=0.003, quat_std=0.3)
"""Standard deviations chosen on four of the flights in docs/estimators.md: markers are up to 4 degrees askew,
and the tilt that the positions show is better than theirs."""
RECORDED = "recorded"
NAME = ("cf1",)


@dataclass(frozen=True, slots=True)
class Feed:
    """Poses as they are sent to the vehicle, at capture, for B replays."""

    sent: Mask
    """(T, B)"""
    pos: Array
    """[m], (T, B, 3)."""
    quat: Array
    """(T, B, 4)"""


@dataclass(frozen=True, slots=True)
class FilteredMotion:
    """States of the mocap filter in one replay, one row per tick."""

    pos: Array
    """[m], (T, 3)."""
    vel: Array
    """[m/s], (T, 3)."""
    quat: Array
    """(T, 4)"""
    ang_vel_body: Array
    """[rad/s], (T, 3)."""
    tracked: Mask
    """Ticks with an accepted sample, (T,)."""


@dataclass(frozen=True, slots=True)
class Estimates:
    """Estimates of one estimator in B replays."""

    pos: Array
    """[m], (T, B, 3)."""
    resets: NDArray[np.int64]
    """Restarts, (B,)."""


def estimates(motion: RecordedMotion, given: Mask, seeds: Sequence[int]) -> Mapping[str, Estimates]:
    """Return estimator -> its estimates in replays.

    Args:
        motion: recorded motion.
        given: samples given in each replay, (T, B).
        seeds: seeds of the inertial sensors' errors, (B,).
    """
    runs = [filtered_motion(motion, one) for one in given.T]
    inertial = inertial_readings(motion, seeds)
    raw = Feed(given, _repeated(motion.pos, given), _repeated(motion.quat, given))
    sent = sent_poses(runs, DELAY * DT)
    never = np.zeros(len(seeds), dtype=np.int64)
    found = {
        "filter": Estimates(predicted_positions(runs, given), never),
        "stock": onboard_estimates(ExtendedKalmanParams(), motion, raw, inertial),
        "fed": onboard_estimates(FED, motion, sent, inertial),
        "all axes": onboard_estimates(ALL_AXES, motion, sent, inertial),
    }
    if motion.own_pos is not None:
        found[RECORDED] = Estimates(_repeated(motion.own_pos, given), never)
    return found


def filtered_motion(motion: RecordedMotion, given: Mask) -> FilteredMotion:
    """Return the states of the mocap filter for a frame each tick, with the vehicle where `given` (T,)."""
    mocap_filter = MocapFilter(MocapFilterParams(), NAME)
    states = [mocap_filter.update(_frame(motion, tick, there=there)) for tick, there in enumerate(given)]
    return FilteredMotion(
        pos=np.concatenate([one.pos for one in states]),
        vel=np.concatenate([one.vel for one in states]),
        quat=np.concatenate([one.quat for one in states]),
        ang_vel_body=np.concatenate([one.ang_vel_body for one in states]),
        tracked=np.concatenate([one.status == TrackStatus.TRACKED for one in states]),
    )


def _frame(motion: RecordedMotion, tick: int, *, there: bool) -> MocapFrame:
    rows = slice(tick, tick + int(there))
    return MocapFrame(t=tick * DT, names=NAME[: int(there)], pos=motion.pos[rows], quat=motion.quat[rows])


def predicted_positions(runs: Sequence[FilteredMotion], given: Mask) -> Array:
    """Return the filter's positions before the sample of each tick (T, B) [m], (T, B, 3)."""
    pos = np.stack([run.pos for run in runs], axis=1)
    moved = pos + DT * np.stack([run.vel for run in runs], axis=1)
    before = np.concatenate([pos[:1], moved[:-1]])
    return np.where(given[..., None], before, pos)


def sent_poses(runs: Sequence[FilteredMotion], delay: float) -> Feed:
    """Return the poses that are sent, moved on by a delay [s]."""
    poses = [extrapolate_pose(run, delay) for run in runs]
    return Feed(
        sent=np.stack([run.tracked for run in runs], axis=1),
        pos=np.stack([pos for pos, _ in poses], axis=1),
        quat=np.stack([quat for _, quat in poses], axis=1),
    )


def inertial_readings(motion: RecordedMotion, seeds: Sequence[int]) -> tuple[Array, Array]:
    """Return specific force [m/s^2] and rate [rad/s] as sensors read them in each replay, (T, B, 3) each."""
    exact = motion.specific_force_body, motion.ang_vel_body
    bias = (VIBRATING.acc_bias, VIBRATING.gyro_bias)
    noise = (VIBRATING.acc_noise, VIBRATING.gyro_noise)
    read: list[Array] = []
    for k, name in enumerate(("accelerometer", "gyroscope")):
        draws = [stream(seed, f"{motion.name} {name}") for seed in seeds]
        steady = np.stack([draw.standard_normal(3) for draw in draws])
        white = np.stack([draw.standard_normal(exact[k].shape) for draw in draws], axis=1)
        read.append(exact[k][:, None] + bias[k] * steady + noise[k] * white)
    return read[0], read[1]


def onboard_estimates(
    params: ExtendedKalmanParams, motion: RecordedMotion, sent: Feed, inertial: tuple[Array, Array]
) -> Estimates:
    """Return what the firmware's filter estimates in each replay."""
    ticks, count = sent.sent.shape
    estimator = ExtendedKalman(params, np.tile(motion.body_quat[0], (count, 1)))
    pos = np.empty((ticks, count, 3))
    for tick in range(ticks):
        flying = bool(motion.flying[tick])
        estimator.predict(inertial[0][tick], inertial[1][tick], flying=flying)
        if tick >= DELAY:
            captured = tick - DELAY
            estimator.correct(sent.sent[captured], sent.pos[captured], sent.quat[captured])
        pos[tick] = estimator.pos
    return Estimates(pos, estimator.resets)


def _repeated(values: Array, given: Mask) -> Array:
    """Return the rows (T, k) for each of B replays, (T, B, k)."""
    return np.repeat(values[:, None], given.shape[1], axis=1)
