"""The paper's training of the networks: Adam, 1e-4, through an adaptive ODE solver, in torch.

Reference for q2q_model.identification.networks.fit, and the only module that imports torch. One step of Adam
solves (14) with the networks for every flight by Dormand-Prince 5(4) with step control (Hairer, Norsett,
Wanner, Solving ODEs I, II.4) and differentiates through the steps of the solver.

    min over w of sum_t sum_j |z_j - zhat_j|^2,                                                      (16)
    zhat_j'' = z_ref'' + K_d (z_ref' - zhat_j') + K_p (z_ref - zhat_j) + eta_j(dr; w)

A non-zero lag of the loop adds a state. Inputs are linear between samples.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import torch

from q2q_model.downwash.envelope_network import HIDDEN, EnvelopeNetwork
from q2q_model.downwash.roles import BLEND
from q2q_model.identification.gains.altitude_record import AltitudeRecord
from q2q_model.identification.networks.fit import RATE
from q2q_model.identification.networks.gradient import ONE, pack
from q2q_model.vehicle.altitude_loop import AltitudeLoop

RTOL, ATOL = 1e-5, 1e-7
"""Tolerances of the solver; the paper gives none. ATOL in m and m/s."""
SAFETY, SHRINK, GROW = 0.9, 0.2, 5.0
"""Step control (Hairer, Norsett, Wanner, II.4)."""

C = (0.0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1.0, 1.0)
A = (
    (),
    (1 / 5,),
    (3 / 40, 9 / 40),
    (44 / 45, -56 / 15, 32 / 9),
    (19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729),
    (9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656),
    (35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84),
)
ERROR = (71 / 57600, 0.0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40)
"""Dormand, Prince, 1980: stages, weights of the fifth order, and the difference to the fourth."""


@dataclass(frozen=True, slots=True)
class _Inputs:
    """One flight as tensors."""

    t: torch.Tensor
    z: torch.Tensor
    """Measured altitude, (T, n)."""
    ref: torch.Tensor
    """(T, n, 3)."""
    across: torch.Tensor
    """(T, p)."""
    i: list[int]
    j: list[int]
    start: torch.Tensor
    """z, z', and with lag the acceleration of the thrust, (s, n)."""


def train(
    records: Sequence[AltitudeRecord], loop: AltitudeLoop, start: EnvelopeNetwork
) -> Iterator[tuple[torch.Tensor, float]]:
    """Yield theta before each of Adam's steps, with its loss (16) [m^2], endlessly."""
    torch.set_num_threads(1)
    flights = [_inputs(record, loop) for record in records]
    theta = torch.tensor(pack(start), dtype=torch.float64, requires_grad=True)
    optimiser = torch.optim.Adam([theta], lr=RATE)
    while True:
        optimiser.zero_grad()
        loss = _loss(flights, loop, theta, start)
        loss.backward()
        yield theta.detach().clone(), float(loss.detach())
        optimiser.step()


def loss_and_gradient(
    records: Sequence[AltitudeRecord], loop: AltitudeLoop, model: EnvelopeNetwork
) -> tuple[float, torch.Tensor]:
    """Return the loss and its gradient with respect to theta, through the solver."""
    theta = torch.tensor(pack(model), dtype=torch.float64, requires_grad=True)
    loss = _loss([_inputs(record, loop) for record in records], loop, theta, model)
    (gradient,) = torch.autograd.grad(loss, theta)
    return float(loss.detach()), gradient


def _loss(
    flights: Sequence[_Inputs], loop: AltitudeLoop, theta: torch.Tensor, shape: EnvelopeNetwork
) -> torch.Tensor:
    """Return the mean over flights of the sum over vehicles of the mean square error [m^2]."""
    parts = [((_simulate(one, loop, theta, shape) - one.z) ** 2).mean(dim=0).sum() for one in flights]
    return torch.stack(parts).mean()


def _inputs(record: AltitudeRecord, loop: AltitudeLoop) -> _Inputs:
    n = len(record.names)
    i = [a for a in range(n) for b in range(n) if a != b]
    j = [b for a in range(n) for b in range(n) if a != b]
    rel = record.pos[:, j] - record.pos[:, i]
    deviation, rate = record.start
    rows, ref = [record.pos[0, :, 2], record.vel[0, :, 2]], record.ref.copy()
    ref[..., 2] += record.added_acc
    if loop.lag > 0.0:
        rows.append(ref[0, :, 2] + loop.offset - loop.k_d * rate - loop.k_p * deviation)
    as_tensor = torch.tensor
    return _Inputs(
        t=as_tensor(record.t),
        z=as_tensor(record.pos[..., 2].copy()),
        ref=as_tensor(ref),
        across=torch.hypot(as_tensor(rel[..., 0]), as_tensor(rel[..., 1])),
        i=i,
        j=j,
        start=torch.stack([as_tensor(row) for row in rows]),
    )


def _simulate(one: _Inputs, loop: AltitudeLoop, theta: torch.Tensor, shape: EnvelopeNetwork) -> torch.Tensor:
    """Return zhat at every tick, (T, n), by the solver, with cubic interpolation between its steps."""

    def rate(t: torch.Tensor, state: torch.Tensor) -> torch.Tensor:
        ref, across = _between(one, t)
        z, v = state[0], state[1]
        command = ref[:, 2] + loop.k_d * (ref[:, 1] - v) + loop.k_p * (ref[:, 0] - z) + loop.offset
        eta = torch.zeros_like(z).index_add(
            0, torch.tensor(one.i), _eta(theta, across, z[one.j] - z[one.i], shape)
        )
        if loop.lag > 0.0:
            return torch.stack((v, state[2] + eta, (command - state[2]) / loop.lag))
        return torch.stack((v, command + eta))

    ticks, found = one.t, [one.start[:1]]
    t, state, step, reached = ticks[0], one.start, float(ticks[1] - ticks[0]), 1
    slope = rate(t, state)
    while reached < len(ticks):
        step = min(step, float(ticks[-1] - t))
        stages = [slope]
        for row, c in zip(A[1:], C[1:], strict=True):
            moved = sum((w * k for w, k in zip(row, stages, strict=True)), start=torch.zeros_like(state))
            stages.append(rate(t + c * step, state + step * moved))
        after = state + step * sum(
            (w * k for w, k in zip(A[6], stages, strict=False)), start=torch.zeros_like(state)
        )
        miss = step * sum((w * k for w, k in zip(ERROR, stages, strict=True)), start=torch.zeros_like(state))
        scale = ATOL + RTOL * torch.maximum(state.abs(), after.abs())
        error = float((miss / scale).detach().pow(2).mean().sqrt())
        if error <= 1.0:
            last = int(torch.searchsorted(ticks, t + step + 1e-12))
            share = ((ticks[reached:last] - t) / step)[:, None]
            found.append(_cubic(share, step, (state[0], slope[0]), (after[0], stages[6][0])))
            t, state, slope, reached = t + step, after, stages[6], last
        step *= min(GROW, max(SHRINK, SAFETY * (error + 1e-12) ** -0.2))
    return torch.cat(found)


def _between(one: _Inputs, t: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
    """Return reference (n, 3) and horizontal distances (p,) at time t."""
    after = int(torch.searchsorted(one.t, t).clamp(1, len(one.t) - 1))
    share = (t - one.t[after - 1]) / (one.t[after] - one.t[after - 1])
    return (
        one.ref[after - 1] + share * (one.ref[after] - one.ref[after - 1]),
        one.across[after - 1] + share * (one.across[after] - one.across[after - 1]),
    )


def _cubic(
    share: torch.Tensor,
    step: float,
    before: tuple[torch.Tensor, torch.Tensor],
    after: tuple[torch.Tensor, torch.Tensor],
) -> torch.Tensor:
    """Return the cubic Hermite interpolant of a step."""
    s2, s3 = share**2, share**3
    return (
        (2 * s3 - 3 * s2 + 1) * before[0]
        + (s3 - 2 * s2 + share) * step * before[1]
        + (3 * s2 - 2 * s3) * after[0]
        + (s3 - s2) * step * after[1]
    )


def _eta(theta: torch.Tensor, across: torch.Tensor, dz: torch.Tensor, shape: EnvelopeNetwork) -> torch.Tensor:
    """Return (15) for pairs, (p,), as in q2q_model.downwash.envelope_network."""
    tanh = torch.tanh(dz / BLEND)
    share, inputs = 0.5 * (1.0 + tanh), torch.stack((across, dz * tanh), dim=-1)
    envelope = torch.exp(-(across**2) / (2.0 * shape.eps**2) - dz**2 / (2.0 * shape.d**2))
    lower, upper = _network(theta[:ONE], inputs), _network(theta[ONE:], inputs)
    return envelope * (share * lower + (1.0 - share) * upper)


def _network(theta: torch.Tensor, inputs: torch.Tensor) -> torch.Tensor:
    first, bias, second, last = torch.split(theta, [2 * HIDDEN, HIDDEN, HIDDEN, 1])
    return torch.tanh(inputs @ first.reshape(HIDDEN, 2).T + bias) @ second + last
