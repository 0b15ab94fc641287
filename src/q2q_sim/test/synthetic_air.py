"""Flights in an air of known values, as records from which an air is learned."""

from dataclasses import dataclass, replace

import numpy as np

from q2q_model.identification.push.along_flight import Motion
from q2q_model.identification.push.push_samples import APART, PushRecord, push_samples
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import GRAVITY
from q2q_sim.air.air_terms import INSIDE, AbsorptionTerm, JetTerm, ResidualTerm
from q2q_sim.air.learning.jet.learned_downwash import learned_downwash
from q2q_sim.air.learning.records.air_record import AirRecord, rows_alone

DT = 0.01
MASS = 0.034
NOISE = 0.1
"""White noise of the measured push [m/s^2]."""


def wide_jet() -> JetTerm:
    """Return a jet with a compact profile, (1 - (r / 0.2)^2)^2, that decays linearly with the gap."""
    gaps, radii = np.linspace(0.0, 1.5, 31), np.linspace(0.0, 0.3, 31)
    profile = np.maximum(1.0 - (radii / 0.2) ** 2, 0.0) ** 2
    push = 3.0 * (1.0 - 0.5 * gaps)[:, None] * profile
    return JetTerm(gaps, radii, np.maximum(push, 0.0), 0.05, 4.0, 0.8, 1.0)


def orbit(seconds: float, heights: tuple[float, ...], seed: int) -> Motion:
    """Return vehicles that weave over each other, tilted as their accelerations demand.

    The first stays where it is; the others pass over it within 0.5 m, 0.15 m up and down.
    """
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, seconds, DT)
    pos = np.zeros((t.size, len(heights), 3))
    for i, height in enumerate(heights):
        wide = 0.0 if i == 0 else 0.35
        for axis, (size, centre) in enumerate([(wide, 0.0), (wide, 0.0), (0.15 * (i > 0), height)]):
            rates, phases = rng.uniform(1.0, 4.0, 3), rng.uniform(0.0, 6.28, 3)
            waves = np.sin(rates * t[:, None] + phases) @ np.array([0.5, 0.3, 0.2])
            pos[:, i, axis] = centre + size * waves
    vel = np.gradient(pos, DT, axis=0)
    lift = np.gradient(vel, DT, axis=0) + np.array([0.0, 0.0, GRAVITY])
    return Motion(t, pos, vel, lift / np.linalg.norm(lift, axis=-1, keepdims=True))


def process(size: int, time: float, rng: np.random.Generator) -> Array:
    """Return an Ornstein-Uhlenbeck process of unit variance, (size,)."""
    keep = np.exp(-DT / time)
    values = rng.standard_normal(size)
    for k in range(1, size):
        values[k] = keep * values[k - 1] + np.sqrt(1.0 - keep**2) * values[k]
    return values


def still_record(name: str, motion: Motion) -> AirRecord:
    """Return a flight whose accelerometer sees gravity alone and whose rotors carry the weight."""
    shape = motion.pos.shape[:2]
    weight = np.full(shape, MASS * GRAVITY)
    whole = np.ones(shape, dtype=bool)
    blank = AirRecord(
        name=name,
        motion=motion,
        samples=(),
        gaps=~whole,
        measured=whole,
        clear=whole & rows_alone(motion.pos, APART),
        specific_force=np.broadcast_to([0.0, 0.0, GRAVITY], (*shape, 3)).copy(),
        command=weight,
        thrust=weight,
        thrust_ratio=np.ones(shape),
        quat=np.broadcast_to([0.0, 0.0, 0.0, 1.0], (*shape, 4)).copy(),
        rate_body=np.zeros((*shape, 3)),
        lag=0.07,
        motors=None,
    )
    return with_push(blank, np.zeros(shape))


def with_push(record: AirRecord, push: Array) -> AirRecord:
    """Return the record with a measured vertical push [m/s^2], (T, n)."""
    names = tuple(f"cf{i}" for i in range(record.vehicles))
    whole = np.ones(push.shape, dtype=bool)
    pushes = PushRecord(record.name, names, record.motion, push, whole, ~whole)
    return replace(record, samples=tuple(push_samples(pushes)))


@dataclass(frozen=True, slots=True)
class Wake:
    """Air under a wake."""

    jet: JetTerm
    absorption: AbsorptionTerm | None = None
    residual: ResidualTerm | None = None


def flown(name: str, motion: Motion, wake: Wake, seed: int) -> AirRecord:
    """Return a flight in a wake, with white noise."""
    record, rng = still_record(name, motion), np.random.default_rng(seed)
    push = NOISE * rng.standard_normal(motion.pos.shape[:2])
    everywhere = np.arange(motion.t.size)
    for i in range(record.vehicles):
        eta = learned_downwash(record, i, everywhere, wake.jet, wake.absorption)
        push[:, i] -= eta
        if wake.residual is not None:
            size = wake.residual.floor_mps2 * np.minimum(eta / INSIDE, 1.0) + wake.residual.slope * eta
            push[:, i] += size * process(motion.t.size, wake.residual.time_s, rng)
    return with_push(record, push)
