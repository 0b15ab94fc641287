"""Make flights with a known downwash, gains and lag, by small steps that know nothing of (14)'s solution."""

from dataclasses import dataclass
from functools import cache

import numpy as np

from q2q_model.downwash.interaction_model import InteractionModel, pairs_at_rest
from q2q_model.downwash.jet import PAPER_LAW
from q2q_model.downwash.no_interaction import NoInteraction
from q2q_model.flights.flight import FLIGHT_FIELDS, Flight, of_rows
from q2q_model.identification.gains.altitude_from_flight import altitude_record
from q2q_model.identification.gains.altitude_record import AltitudeRecord
from q2q_model.signals.values import Array
from q2q_model.vehicle.altitude_loop import AltitudeLoop
from q2q_model.vehicle.constants import CRAZYFLIE_2_0, GRAVITY

STEP, TICK = 0.002, 0.01
"""Physics and recording [s]."""
GUST_S = 0.25
LOOP = AltitudeLoop(k_p=0.81, k_d=0.43, lag=0.1)
PLAIN = AltitudeLoop(k_p=0.81, k_d=0.43)


@dataclass(frozen=True, slots=True)
class Pass:
    """Flight in which Q2 passes over Q1 at `speed` [m/s], `gap` [m] above it."""

    name: str = "pass"
    gap: float = 0.5
    speed: float = 0.5
    seconds: float = 30.0
    start: float = 0.0
    """Q1 starts this far above its reference [m]."""
    loop: AltitudeLoop = LOOP
    law: InteractionModel = PAPER_LAW
    noise: float = 0.0
    """Of measured positions [m] and, fifty times this, of velocities and accelerations."""
    gust: float = 0.0
    """Standard deviation of vertical gusts, correlated over a quarter of a second [m/s^2]."""


CALM = Pass(law=NoInteraction(), start=0.3, noise=1e-4)
"""Shows the gains: Q1 settles, and nobody is pushed."""
PASSES = [Pass(name=f"gap {gap}", gap=gap, noise=1e-4) for gap in (0.4, 0.6, 0.9)]


def record_of(made: Pass) -> AltitudeRecord:
    """Return the record of a made flight."""
    return altitude_record(made_flight(made), CRAZYFLIE_2_0)


def without(flight: Flight, *holes: slice) -> Flight:
    """Return a flight without some of its ticks."""
    kept = np.ones(flight.t.size, dtype=bool)
    for hole in holes:
        kept[hole] = False
    return of_rows(flight, kept)


@cache
def made_flight(made: Pass) -> Flight:
    """Return the recorded flight: places, references, commands, accelerometer."""
    ticks = round(made.seconds / TICK)
    t = np.arange(ticks) * TICK
    pos, vel, thrust, eta = _fly(made, ticks)
    rng = np.random.default_rng(11)
    seen = pos + made.noise * rng.standard_normal(pos.shape)
    seen_vel = vel + 50.0 * made.noise * rng.standard_normal(vel.shape)
    level = np.tile([0.0, 0.0, 0.0, 1.0], (ticks, 2, 1))
    ref = np.tile([[0.0, 0.0, 1.0], [0.0, 0.0, 1.0 + made.gap]], (ticks, 1, 1))
    lift = -made.loop.k_p * (seen - ref)[..., 2] - made.loop.k_d * seen_vel[..., 2] + made.loop.offset
    acc = thrust + eta + 50.0 * made.noise * rng.standard_normal(eta.shape)
    force = np.stack([np.zeros_like(acc), np.zeros_like(acc), acc + GRAVITY], axis=-1)
    names = [name for fields in FLIGHT_FIELDS.values() for name in fields.values()]
    unknown = {name: np.full((ticks, 2, 3), np.nan) for name in names}
    flat = {name: np.full((ticks, 2), np.nan) for name in ("thrust", "roll", "pitch", "command_status")}
    known = {
        "mocap_pos": seen, "mocap_quat": level, "pos": seen, "vel": seen_vel, "quat": level, "ref_pos": ref,
        "ref_vel": np.zeros_like(ref), "ref_acc": np.zeros_like(ref), "specific_force_body": force,
        "thrust": CRAZYFLIE_2_0.mass * (GRAVITY + lift), "command_status": np.zeros((ticks, 2)),
        "true_pos": pos, "true_eta": np.stack([0.0 * eta, 0.0 * eta, eta], axis=-1),
    }  # fmt: skip
    return Flight(name=made.name, names=("cf1", "cf2"), t=t, **(unknown | flat | known))


def _fly(made: Pass, ticks: int) -> tuple[Array, Array, Array, Array]:
    """Return pos, vel (T, 2, 3), lagged lift with gusts and eta (T, 2), by semi-implicit steps of 2 ms."""
    loop, per = made.loop, round(TICK / STEP)
    pos, vel = np.zeros((ticks, 2, 3)), np.zeros((ticks, 2, 3))
    lifts, etas = np.zeros((ticks, 2)), np.zeros((ticks, 2))
    ref = np.array([1.0, 1.0 + made.gap])
    z, v = ref + np.array([made.start, 0.0]), np.zeros(2)
    lift = loop.offset - loop.k_p * (z - ref)
    gust, stir = np.zeros(2), np.random.default_rng(12)
    for k in range(ticks * per):
        y = np.array([0.0, np.clip(made.speed * (k * STEP - made.seconds / 2), -1.0, 1.0)])
        rel = np.array([0.0, y[1] - y[0], z[1] - z[0]])
        both = np.stack((rel, -rel))
        eta = made.law.acceleration(both, pairs_at_rest(both))[:, 2]
        if k % per == 0:
            row = k // per
            pos[row, :, 1], pos[row, :, 2], vel[row, :, 2] = y, z, v
            vel[row, 1, 1] = made.speed if abs(y[1]) < 1.0 else 0.0
            lifts[row], etas[row] = lift + gust, eta
        expected = loop.offset - loop.k_p * (z - ref) - loop.k_d * v
        lift = lift + (1.0 - np.exp(-STEP / loop.lag)) * (expected - lift) if loop.lag > 0.0 else expected
        v = v + STEP * (lift + gust + eta)
        z = z + STEP * v
        if made.gust > 0.0:
            kick = made.gust * (2.0 * STEP / GUST_S) ** 0.5
            gust = (1.0 - STEP / GUST_S) * gust + kick * stir.normal(size=2)
    return pos, vel, lifts, etas
