"""Exact response of the altitude loop (14) to downwash, reference jerk, and what a controller adds to it.

In epsilon = z - z_ref the reference cancels. Without lag, and with a thrust lag T,

    epsilon'' = -K_d epsilon' - K_p epsilon + K_i xi + b + eta,   xi' = -epsilon
    epsilon'' = delta + eta,   T delta' = -K_d epsilon' - K_p epsilon + K_i xi + b - delta - T z_ref'''

so epsilon = free response (start, b, reference's jerk) + sum over k of h_(t-k) eta_k. h is the response to
eta that is 1 at one sample and falls linearly to 0 at its neighbours: exact for eta linear between samples
(matrix exponential; Van Loan, Computing integrals involving the matrix exponential, 1978).

A controller adds its feed-forward and a constant, -c eta_ff + b_i. c is found from the commands
(command_gains). Their own constant is not b: most of it balances a weak battery, a mass that the controller
does not know, or downwash that an integral has learned, and pushes nobody. So b is what clear air shows, from
the altitudes of each vehicle of a record once its loop has settled after another was near,

    b = sum (epsilon - epsilon(b = 0)) s / sum s^2          s: response to a unit offset (trajectory_gains)

and 0 for a vehicle that is too seldom alone: its loop then counts as balanced.

| symbol | name | meaning [unit] |
|---|---|---|
| epsilon | deviation | altitude minus reference [m] |
| h | | response of epsilon to a unit eta at one sample [s^2] |
| b_i - c eta_ff | added_acc | what a controller adds [m/s^2] |
| c | compensated | share of the predicted downwash eta_ff that it compensates [-] |
| c_v c_a | of_rates | use of the rates of references next to the loop (command_gains) [1/s], [-] |
| Phi, Gamma0, Gamma1 | step | x_(k+1) = Phi x_k + Gamma0 u_k + Gamma1 u_(k+1) |
"""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from scipy.linalg import expm

from q2q_model.compiled import compiled
from q2q_model.flights.masks_over_time import last_time
from q2q_model.identification.gains.altitude_record import AltitudeRecord, in_clear_air
from q2q_model.signals.values import Array, Mask
from q2q_model.vehicle.altitude_loop import AltitudeLoop

CLEAR = 0.5
"""Horizontal distance from all others beyond which a vehicle is in clear air [m]."""
SETTLED = 3.0
"""Time constants after which a loop has forgotten a push [-]: a twentieth is left."""
LEAST = 2.0
"""Minimum time in clear air from which a constant is inferred [s]."""


@dataclass(frozen=True, slots=True)
class LoopStep:
    """Exact step of one sample; inputs are eta, b and the reference's jerk."""

    phi: Array
    """(s, s), states epsilon, epsilon', xi, delta (s = 3 without lag)."""
    gamma0: Array
    """Effect of the inputs at the sample, (s, 3)."""
    gamma1: Array
    """Effect of the inputs at the next sample, (s, 3)."""


@lru_cache(maxsize=8)
def loop_step(loop: AltitudeLoop, dt: float) -> LoopStep:
    """Return the exact step of a loop over dt [s] for inputs linear between samples.

    It is kept, as all records of a fit ask for the same: a matrix exponential costs more than a response.
    """
    a, b = _continuous(loop)
    s, m = b.shape
    block = np.zeros((s + 2 * m, s + 2 * m))
    block[:s, :s], block[:s, s : s + m] = a * dt, b * dt
    block[s : s + m, s + m :] = np.eye(m)
    whole = expm(block)
    gamma1 = whole[:s, s + m :]
    phi = np.ascontiguousarray(whole[:s, :s])
    return LoopStep(phi=phi, gamma0=whole[:s, s : s + m] - gamma1, gamma1=gamma1)


def impulse_response(loop: AltitudeLoop, dt: float, length: int) -> Array:
    """Return h [s^2], (length,)."""
    step = loop_step(loop, dt)
    push = np.zeros((length, step.phi.shape[0], 1))
    push[:1, :, 0] = step.gamma0[:, 0]
    return _march(step.phi, push, np.ascontiguousarray(step.gamma1[:, :1]))[:, 0]


def free_response(
    loop: AltitudeLoop, dt: float, start: Array, jerk: Array, added_acc: Array | float = 0.0
) -> Array:
    """Return epsilon [m], (T, n), of vehicles without downwash.

    Args:
        loop: altitude loop with a constant offset b.
        dt: time between samples [s].
        start: epsilon and epsilon' at the first sample [m], [m/s], (2, n).
        jerk: third derivative of the altitude reference [m/s^3], (T, n).
        added_acc: commanded acceleration in addition to that of the loop [m/s^2], (T, n).
    """
    step = loop_step(replace(loop, offset=0.0), dt)  # b is an input
    state = np.zeros((step.phi.shape[0], start.shape[1]))
    state[:2] = start
    added = np.broadcast_to(loop.offset + np.asarray(added_acc), jerk.shape)  # (T, n)
    if loop.lag > 0.0:
        state[3] = added[0] - loop.k_d * start[1] - loop.k_p * start[0]  # thrust settled on its command
    after, later = (np.concatenate((one[1:], one[-1:])) for one in (jerk, added))
    push = jerk[:, None] * step.gamma0[:, 2:] + after[:, None] * step.gamma1[:, 2:]  # (T, s, n)
    push += added[:, None] * step.gamma0[:, 1:2] + later[:, None] * step.gamma1[:, 1:2]
    return _march(step.phi, push, state)


def offset_response(record: AltitudeRecord, loop: AltitudeLoop) -> Array:
    """Return s [s^2], (T, 1): epsilon of a vehicle that begins on its reference, for b = 1 m/s^2."""
    still = np.zeros((record.t.size, 1))
    return free_response(replace(loop, offset=1.0), record.dt, still[:2], still)


def undisturbed(record: AltitudeRecord, loop: AltitudeLoop) -> Array:
    """Return epsilon [m], (T, n), that a record's vehicles would have without downwash."""
    return free_response(loop, record.dt, record.start, record.jerk, record.added_acc)


def with_added_acc(
    record: AltitudeRecord, loop: AltitudeLoop, compensated: float, of_rates: tuple[float, float] = (0.0, 0.0)
) -> AltitudeRecord:
    """Return the record with `added_acc`, given the loop without offset, c [-], and c_v and c_a."""
    known = np.isfinite(record.feed_forward)
    rates = record.ref[..., 1:] @ np.array(of_rates) * record.rates_fitted  # (T, n)
    fed = replace(record, added_acc=rates - compensated * np.where(known, record.feed_forward, 0.0))
    return replace(fed, added_acc=fed.added_acc + _constant(fed, loop))


def _constant(record: AltitudeRecord, loop: AltitudeLoop) -> Array:
    """Return b of every vehicle [m/s^2], (n,); 0 where it is not known."""
    known = knows_constant(record, loop)
    if not known.any():
        return np.zeros(len(record.names))
    response = offset_response(record, loop)
    weight = _settled(record, loop) * response  # (T, n)
    found = (weight * (record.deviation - undisturbed(record, loop))).sum(axis=0)
    return np.where(known, found / np.maximum((weight * response).sum(axis=0), 1e-300), 0.0)


def knows_constant(record: AltitudeRecord, loop: AltitudeLoop) -> Mask:
    """Return for which vehicles settled clear air shows b, (n,); none for a loop that does not settle."""
    if not (loop.k_p > 0.0 and loop.k_d > 0.0):
        return np.zeros(len(record.names), dtype=np.bool_)
    rows = _settled(record, loop) & (offset_response(record, loop) != 0.0)
    return np.asarray(np.count_nonzero(rows, axis=0) * record.dt >= LEAST)


def _settled(record: AltitudeRecord, loop: AltitudeLoop) -> Mask:
    """Return the ticks of each vehicle whose loop has settled since it was last near another, (T, n)."""
    settling = SETTLED * max(2.0 / loop.k_d, loop.k_d / loop.k_p)
    last_near = last_time(~in_clear_air(record, CLEAR), record.t)
    return np.asarray(record.t[:, None] - last_near >= settling)


def downwash_response(loop: AltitudeLoop, dt: float, eta: Array) -> Array:
    """Return epsilon [m], (T, n), of vehicles initially at rest under downwash eta [m/s^2], (T, n)."""
    step = loop_step(loop, dt)
    after = np.concatenate((eta[1:], eta[-1:]))
    push = eta[:, None] * step.gamma0[:, :1] + after[:, None] * step.gamma1[:, :1]
    return _march(step.phi, push, step.gamma1[:, :1] * eta[0])


@compiled
def _march(phi: Array, push: Array, state: Array) -> Array:
    """Return the first state of x_(k+1) = phi x_k + push_k, (T, n), from `state` (s, n)."""
    first = np.empty((push.shape[0], state.shape[1]))
    for k in range(push.shape[0]):
        first[k] = state[0]
        state = np.dot(phi, state) + push[k]
    return first


def _continuous(loop: AltitudeLoop) -> tuple[Array, Array]:
    """Return A (s, s) and B (s, 3) of the continuous loop."""
    feedback = np.array([-loop.k_p, -loop.k_d, loop.k_i])
    if loop.lag == 0.0:
        a = np.array([[0.0, 1.0, 0.0], feedback, [-1.0, 0.0, 0.0]])
        return a, np.array([[0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 0.0, 0.0]])
    a = np.zeros((4, 4))
    a[0, 1], a[1, 3], a[2, 0] = 1.0, 1.0, -1.0
    a[3, :3], a[3, 3] = feedback / loop.lag, -1.0 / loop.lag
    b = np.zeros((4, 3))
    b[1, 0], b[3, 1], b[3, 2] = 1.0, 1.0 / loop.lag, -1.0
    return a, b
