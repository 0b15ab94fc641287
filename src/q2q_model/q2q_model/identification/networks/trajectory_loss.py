"""Training loss (16) and its exact gradient, without an ODE solver.

    loss = sum over t, i of (z_i - zhat_i)^2,   zhat_i = z_free,i + (h * eta_i)
    eta_i = sum over j of eta(dxy_ij, zhat_j - zhat_i)

eta is non-zero only on the few samples S in which a pair is near; h is the loop's impulse response
(q2q_model.identification.gains.impulse_response). With eta on S as the unknown,

    zhat_S = z_free,S + H eta        H = Toeplitz(h) on S: strictly causal, a fixed point in a few sweeps
    loss_i = r'r - 2 q_i . eta_i + eta_i' G eta_i,  G = K'K, q = K'r, K = Toeplitz(h) from S to all samples

and the gradient follows from the adjoint of the fixed point,
lambda = 2 (G eta - q) + H' (d eta / d zhat)' lambda. There is no approximation: the value is that of an
exact solver with eta linear between samples.

| symbol | name | meaning [unit] |
|---|---|---|
| S | active | samples in which some pair is within reach |
| r | | measured altitude minus free response [m] |
| z_free | free | altitude without downwash [m], on S |
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from q2q_model.downwash.envelope_network import EnvelopeNetwork
from q2q_model.identification.gains.altitude_record import AltitudeRecord, decimate
from q2q_model.identification.gains.impulse_response import impulse_response, undisturbed
from q2q_model.identification.networks.gradient import Evaluation, evaluate, pullback
from q2q_model.signals.values import Array, Rows
from q2q_model.vehicle.altitude_loop import AltitudeLoop

WIDE = 6.0
"""Widths of the envelope beyond which eta is zero: it is 1.5e-8 of its peak there [-]."""
MOST_ACTIVE = 1000
"""Most active samples of a flight, about 20 ms per loss; longer encounters are decimated."""
SETTLED = 1e-9
"""Change of eta that ends the iteration [m/s^2]: at most a nanometre of altitude."""
SWEEPS = 60
"""Most sweeps; a sweep contracts by at least half if the loop is slower than the encounters."""


class DivergingModelError(ValueError):
    """Error for a model whose fixed point of altitude and downwash diverges."""


@dataclass(frozen=True, slots=True)
class FlightTerms:
    """Terms of one flight in the loss."""

    name: str
    i: Rows
    """Exposed vehicle of each ordered pair, (p,)."""
    j: Rows
    """Source of each ordered pair, (p,)."""
    across: Array
    """Horizontal distance [m], (S, p), measured."""
    dz: Array
    """Height of j above i [m], (S, p), measured."""
    free: Array
    """(S, n)."""
    H: Array
    G: Array
    """(S, S)."""
    q: Array
    """(S, n)."""
    rr: Array
    """r'r [m^2], (n,)."""
    ticks: int
    """T."""


@dataclass(frozen=True, slots=True)
class LossValue:
    """Value, gradient and parts of the loss."""

    mse: tuple[Array, ...]
    """Mean square error of each vehicle of each flight [m^2], (n,) each."""
    loss: float
    """Mean over flights of the sum over vehicles [m^2]."""
    gradient: Array
    """Gradient with respect to theta, (322,)."""
    etas: tuple[Array, ...]
    """eta on the active samples of each flight, a start for the next evaluation."""


def active_samples(record: AltitudeRecord, reach: tuple[float, float]) -> Rows:
    """Return the samples in which some pair is within reach, (S,)."""
    active = np.zeros(record.t.size, dtype=np.bool_)
    for i in range(len(record.names)):
        rel = record.pos[:, i + 1 :] - record.pos[:, i : i + 1]  # (T, n - 1 - i, 3)
        near = (np.hypot(rel[..., 0], rel[..., 1]) < reach[0]) & (np.abs(rel[..., 2]) < reach[1])
        active |= near.any(axis=1)
    return np.nonzero(active)[0]


def flight_terms(record: AltitudeRecord, loop: AltitudeLoop, reach: tuple[float, float]) -> FlightTerms:
    """Return the terms of one flight in the loss, decimated to at most `MOST_ACTIVE` active samples.

    Args:
        record: altitude record of the flight.
        loop: altitude loop of every vehicle.
        reach: horizontal and vertical distance [m] beyond which eta is zero.
    """
    every = -(-active_samples(record, reach).size // MOST_ACTIVE)
    record = decimate(record, every) if every > 1 else record
    n = len(record.names)
    i, j = np.nonzero(~np.eye(n, dtype=np.bool_))
    active = active_samples(record, reach)
    rel = record.pos[active][:, j] - record.pos[active][:, i]  # (S, p, 3)
    free = undisturbed(record, loop)
    r = record.deviation - free
    h = impulse_response(loop, record.dt, record.t.size)
    K = np.zeros((record.t.size, active.size), order="F")  # (T, S)
    for column, tick in enumerate(active):
        K[tick:, column] = h[: record.t.size - tick]
    return FlightTerms(
        name=record.name,
        i=i,
        j=j,
        across=np.hypot(rel[..., 0], rel[..., 1]),
        dz=rel[..., 2],
        free=(record.ref[..., 0] + free)[active],
        H=K[active],
        G=K.T @ K,
        q=K.T @ r,
        rr=(r * r).sum(axis=0),
        ticks=record.t.size,
    )


def trajectory_loss(
    model: EnvelopeNetwork, terms: Sequence[FlightTerms], near: Sequence[Array] | None = None
) -> LossValue:
    """Return the loss of a model on flights, with its exact gradient.

    Args:
        model: networks.
        terms: terms of the flights.
        near: eta of a similar model, as the start of the fixed point.
    """
    starts = near or [
        _sum_over_sources(one, evaluate(model, one.across.ravel(), one.dz.ravel()).eta) for one in terms
    ]
    solved = [_solve(model, one, start) for one, start in zip(terms, starts, strict=True)]
    etas = tuple(_sum_over_sources(one, at.eta) for one, at in zip(terms, solved, strict=True))
    mse = tuple(mean_square(one, eta) for one, eta in zip(terms, etas, strict=True))
    parts = [
        pullback(model, at, _adjoint(one, at, eta)) / one.ticks
        for one, at, eta in zip(terms, solved, etas, strict=True)
    ]
    gradient = np.asarray(np.sum(parts, axis=0) / len(terms))
    loss = float(np.mean([one.sum() for one in mse]))
    return LossValue(mse=mse, loss=loss, gradient=gradient, etas=etas)


def mean_square(one: FlightTerms, eta: Array) -> Array:
    """Return the mean square error of every vehicle's altitude [m^2], (n,), under eta (S, n)."""
    squares = one.rr - 2.0 * (one.q * eta).sum(axis=0) + (eta * (one.G @ eta)).sum(axis=0)
    return np.asarray(squares / one.ticks)


def _solve(model: EnvelopeNetwork, one: FlightTerms, eta: Array) -> Evaluation:
    """Return the pairs' evaluation at the simulated heights, by sweeps from `eta` (S, n).

    Raises:
        DivergingModelError: the fixed point is not reached.
    """
    for _ in range(SWEEPS):
        at = evaluate(model, one.across.ravel(), _heights(one, eta).ravel())
        before, eta = eta, _sum_over_sources(one, at.eta)
        if eta.size == 0 or np.abs(eta - before).max() < SETTLED:
            return at
    raise DivergingModelError(f"flight {one.name}: the simulated altitudes do not settle in {SWEEPS} sweeps")


def _adjoint(one: FlightTerms, at: Evaluation, eta: Array) -> Array:
    """Return the total derivative of the loss with respect to each pair's eta, (S * p,)."""
    slope = at.slope.reshape(one.across.shape)
    direct = 2.0 * (one.G @ eta - one.q)
    adjoint = direct
    for _ in range(SWEEPS):
        before = adjoint
        pushed = one.H.T @ (slope * adjoint[:, one.i])  # (S, p)
        adjoint = direct.copy()
        for k, (i, j) in enumerate(zip(one.i, one.j, strict=True)):
            adjoint[:, j] += pushed[:, k]
            adjoint[:, i] -= pushed[:, k]
        if adjoint.size == 0 or np.abs(adjoint - before).max() <= 1e-9 * np.abs(adjoint).max():
            break
    return adjoint[:, one.i].ravel()


def _heights(one: FlightTerms, eta: Array) -> Array:
    """Return simulated zhat_j - zhat_i [m], (S, p)."""
    z = one.free + one.H @ eta
    return np.asarray(z[:, one.j] - z[:, one.i])


def _sum_over_sources(one: FlightTerms, of_pairs: Array) -> Array:
    """Return the sum over sources, (S, n), of eta of pairs (S * p,)."""
    eta = np.zeros_like(one.free)
    for k, i in enumerate(one.i):
        eta[:, i] += of_pairs.reshape(one.across.shape)[:, k]
    return eta
