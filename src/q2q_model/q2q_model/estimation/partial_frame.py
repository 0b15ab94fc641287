"""Take a tick in which nobody lies but some are absent, in compiled loops, each vehicle by its own clock.

A swarm of a hundred is hardly ever whole: with one sample in a thousand lost, every tenth tick lacks
somebody, and whoever comes back has gains of its own for a while. The equations are those of white_jerk,
positions and attitudes; a tick in which a sample is refused, a vehicle lost, unseen or found again is left
untouched, and told by False, for those files to sort out.

| symbol | name | meaning [unit] |
|---|---|---|
| x | state | rows p v a, columns x y z, (n, 3, 3) |
| P | cov | covariance of (p, v, a), (n, 3, 3) |
| | since | time since a vehicle's last sample [s], (n,) |
| | numbers | columns NOISE_VAR to ROOM, (8,) |
| | turning | turn_max [rad], turn_rate_max [rad/s], rate_filter_s, coast_s [s] |
"""

import math

import numpy as np

from q2q_model.compiled import compiled
from q2q_model.estimation.usual_frame import turn_of, turned
from q2q_model.estimation.white_jerk import ACC_HORIZON
from q2q_model.signals.values import Array

NOISE_VAR, DENSITY, COAST, JUMP, SPEED, SIGMAS, ROOM, ROUNDING = range(8)
"""sigma^2 [m^2], q [m^2/s^5], coast_s [s], jump_max [m], speed_max [m/s], GATE_SIGMAS, pos_max [m], [s]."""
EXPECTED, SPREAD = slice(3, 12), slice(12, 21)
"""Columns of a vehicle's working memory that hold x- and P-; before them its sample (3)."""
WIDTH = 21


def _expect(state: Array, cov: Array, since: float, numbers: Array, work: Array) -> None:
    """Write x- and P- of one vehicle into its working memory."""
    tau = min(since, numbers[COAST])
    h, q = min(tau, ACC_HORIZON), numbers[DENSITY]
    a = h * (tau - 0.5 * h)
    for k in range(3):
        work[3 + k] = state[0, k] + tau * state[1, k] + a * state[2, k]
        work[6 + k] = state[1, k] + h * state[2, k]
        work[9 + k] = state[2, k]
        work[12 + k] = cov[0, k] + tau * cov[1, k] + a * cov[2, k]  # F P, row by row
        work[15 + k] = cov[1, k] + h * cov[2, k]
        work[18 + k] = cov[2, k]
    for row in range(12, 21, 3):  # (F P) F^T
        work[row] += tau * work[row + 1] + a * work[row + 2]
        work[row + 1] += h * work[row + 2]
    pv, pa, va = q * tau**4 / 8.0, q * tau**3 / 6.0, q * tau**2 / 2.0
    work[12] += q * tau**5 / 20.0
    work[13] += pv
    work[14] += pa
    work[15] += pv
    work[16] += q * tau**3 / 3.0
    work[17] += va
    work[18] += pa
    work[19] += va
    work[20] += q * tau


def _expect_all(tracks: tuple[Array, Array, Array], numbers: Array, work: Array) -> None:
    since, state, cov = tracks
    for i in range(since.size):
        expect(state[i], cov[i], since[i], numbers, work[i])


def _fits(state: Array, since: float, numbers: Array, work: Array) -> bool:
    """Return whether a vehicle's sample is within the gates of what is expected."""
    gate = numbers[JUMP] + numbers[SIGMAS] * math.sqrt(work[12] + numbers[NOISE_VAR])
    reach = numbers[JUMP] + numbers[SPEED] * since
    miss = step = 0.0
    for k in range(3):
        if not abs(work[k]) <= numbers[ROOM]:
            return False
        miss += (work[k] - work[3 + k]) ** 2
        step += (work[k] - state[0, k]) ** 2
    return bool(miss <= gate**2 and step <= reach**2)


def _correct(state: Array, cov: Array, noise_var: float, work: Array) -> None:
    """Take a vehicle's sample."""
    variance = work[12] + noise_var
    for k in range(3):
        miss = work[k] - work[3 + k]
        for row in range(3):
            gain = work[12 + 3 * row] / variance
            state[row, k] = work[3 + 3 * row + k] + gain * miss
            cov[row, k] = work[12 + 3 * row + k] - gain * work[12 + k]
        if noise_var == 0.0:
            state[0, k] = work[k]


def _follow_present(
    measured: Array, tracks: tuple[Array, Array, Array], numbers: Array, work: Array, out: Array
) -> bool:
    since, state, cov = tracks
    for i in range(measured.shape[0]):
        if since[i] > numbers[COAST] + numbers[ROUNDING]:
            return False
        work[i, :3] = measured[i]
        expect(state[i], cov[i], since[i], numbers, work[i])
        absent = math.isnan(measured[i, 0] + measured[i, 1] + measured[i, 2])
        if not (absent or fits(state[i], since[i], numbers, work[i])):
            return False
    for i in range(measured.shape[0]):
        if math.isnan(measured[i, 0] + measured[i, 1] + measured[i, 2]):
            out[i, :6] = work[i, 3:9]
            continue
        correct(state[i], cov[i], numbers[NOISE_VAR], work[i])
        for k in range(3):
            out[i, k], out[i, 3 + k] = state[i, 0, k], state[i, 1, k]
    return True


def _turn_present(
    pose: Array, track: tuple[Array, Array], since: Array, turning: tuple[float, float, float, float]
) -> bool:
    (quat, rate), turn = track, np.empty(4)
    turn_max, rate_max, lag, coast = turning
    for i in range(pose.shape[0]):
        believable = min(turn_max + rate_max * since[i], math.pi)
        if math.isnan(pose[i, 3] + pose[i, 4] + pose[i, 5] + pose[i, 6]):
            continue
        whole = turn_of(quat[i], pose[i], turn) > 0.0
        if not (whole and since[i] <= coast and abs(turn[3]) >= math.cos(0.5 * believable)):
            return False
    for i in range(pose.shape[0]):
        if math.isnan(pose[i, 3] + pose[i, 4] + pose[i, 5] + pose[i, 6]):
            rate[i] = 0.0
            continue
        turned(quat[i], rate[i], pose[i], turn, (since[i], 0.0, since[i] / (since[i] + lag)))
    return True


expect, fits, correct = compiled(_expect), compiled(_fits), compiled(_correct)
expect_all = compiled(_expect_all)
"""Write x- and P- of every vehicle into `work` (n, WIDTH); the arguments are those of follow_present."""
follow_present = compiled(_follow_present)
"""Move `tracks` (since, state, cov) on by measured (n, 3) with NaN where absent, write position and velocity
of all into `out` (n, 6); `work` is (n, WIDTH). False, and no track changed, where anything is unusual."""
turn_present = compiled(_turn_present)
"""Turn (quat (n, 4), rate (n, 3)) on by pose (n, 7); rates of absent ones are zero. False as above."""
