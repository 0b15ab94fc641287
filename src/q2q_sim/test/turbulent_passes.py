"""Passes below another vehicle in turbulence, recorded under a known law."""

from dataclasses import replace
from functools import cache

import numpy as np

from q2q_model.geometry.rotations import UP, identity_quat, rotate
from q2q_model.identification.push.along_flight import Motion
from q2q_model.identification.push.push_samples import PushRecord, scored_rows
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import CRAZYFLIE_2_0
from q2q_sim.air.wake_laws import WakeLaw
from q2q_sim.experiments.validation.drawn_air import Draw, MakeDraw
from q2q_sim.experiments.validation.recorded.recorded_law import LOOP, ReadFlight, RecordedLaw
from q2q_sim.experiments.validation.recorded.tracked_flight import TrackedFlight
from q2q_sim.experiments.validation.redrawn_flight import redraw_flight
from q2q_sim.plant.disturbance import Disturbance, DisturbanceParams
from q2q_sim.plant.swarm import Swarm

DT = 0.01
NAMES = ("cf1", "cf2")
LAW = RecordedLaw(
    k_p=np.array([20.0, 20.0, 10.0]),
    k_d=np.array([10.0, 10.0, 5.0]),
    k_i=np.array([0.6, 0.6, 0.6]),
    offset=np.zeros((2, 3)),
    rms=0.0,
    attitude=replace(LOOP, frequency=60.0),
)
TURBULENCE, MEMORY = 0.15, 0.9
"""Standard deviation of the turbulence [m/s^2], and what is left of it after 10 ms: 0.1 s."""


class Turbulent(Swarm):
    """Swarm in `strength` times the measured downwash, with turbulence."""

    def __init__(self, start: Array, strength: float, seed: int) -> None:
        super().__init__(NAMES, CRAZYFLIE_2_0, start, WakeLaw.MEASURED)
        self._strength, self._rng, self._now = strength, np.random.default_rng(seed), np.zeros(2)

    def step(self, commands: Array, drive: Array) -> None:
        """Advance with the rest of the downwash and the turbulence as moving air."""
        fresh = TURBULENCE * np.sqrt(1.0 - MEMORY**2) * self._rng.standard_normal(2)
        self._now = MEMORY * self._now + fresh
        air = drive.copy()
        air[:, 2] += self._now + (self._strength - 1.0) * self.downwash()[:, 2]
        super().step(commands, air)


def air(strength: float, first: int = 0) -> MakeDraw:
    """Return what makes swarms in an air of this strength, their seeds counted from `first`."""
    still = DisturbanceParams()

    def make(seed: int, start: Array) -> Draw:
        return Draw(Turbulent(start, strength, first + seed), Disturbance(still, 2, DT, seed))

    return make


def passes(seconds: float, period: float = 8.0) -> TrackedFlight:
    """Return a plan: cf1 swings along x below cf2, which stays 0.4 m above; both bob."""
    t = DT * np.arange(round(seconds / DT))
    bob, still = 0.05 * np.sin(2.1 * t), np.zeros_like(t)
    lower = np.stack([0.4 * np.cos(2.0 * np.pi * t / period), still, 0.6 + bob], axis=-1)
    upper = np.stack([0.1 * np.sin(t), 0.1 * np.cos(0.7 * t), 1.0 + bob], axis=-1)
    ref = np.stack([lower, upper], axis=1)
    vel = np.gradient(ref, DT, axis=0)
    rng = np.random.default_rng(1)
    none = np.zeros((len(t), 2), dtype=bool)
    return TrackedFlight(
        name="passes",
        names=NAMES,
        dt=DT,
        pos=ref + 2e-4 * rng.standard_normal(ref.shape),
        vel=vel + 1e-3 * rng.standard_normal(ref.shape),
        quat=identity_quat((len(t), 2)),
        ref_pos=ref,
        ref_vel=vel,
        ref_acc=np.gradient(vel, DT, axis=0),
        acc=np.full(ref.shape, np.nan),
        thrust=np.zeros((len(t), 2)),
        compensated=np.zeros((len(t), 2)),
        usable=~none,
        exposed=none,
        free=none,
        scored=np.ones(2, dtype=bool),
        sure=~none,
        stepped=none,
    )


def recorded(plan: TrackedFlight, make: MakeDraw) -> TrackedFlight:
    """Return a plan as flown under LAW by the first draw of an air."""
    flown = redraw_flight(ReadFlight(plan, LAW), CRAZYFLIE_2_0.mass, make, [0])
    pos, vel, quat = flown.pos[0], flown.vel[0], flown.quat[0]
    everywhere = np.ones(pos.shape[:2], dtype=bool)
    motion = Motion(plan.t, pos, vel, rotate(quat, UP))
    pushes = PushRecord("passes", NAMES, motion, np.zeros(pos.shape[:2]), everywhere, ~everywhere)
    rows = scored_rows(pushes)
    exposed, free = (np.stack([getattr(row, what) for row in rows], axis=1) for what in ("exposed", "free"))
    thrust = flown.thrust[0]
    return replace(plan, pos=pos, vel=vel, quat=quat, thrust=thrust, exposed=exposed, free=free)


@cache
def recorded_passes() -> TrackedFlight:
    """Return a flight in the air of strength 1."""
    return recorded(passes(24.0), air(1.0, first=100))
