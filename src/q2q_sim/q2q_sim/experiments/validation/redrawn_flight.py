"""A recorded flight flown again by its own law in simulated air, many draws side by side.

Each draw starts from the recorded first state and follows the recorded references at the recorded rate. The
controller reads the true state with the noise of the recorded estimate (estimate_noise), without delay. The
downwash that it expects follows from this state by its interaction model; without one it is that recorded.
The vehicles feel the drag of their rotors (rotor_drag).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from q2q_model.downwash.predictor import InteractionPredictor
from q2q_model.geometry.rotations import UP, yaw_from_quat
from q2q_model.signals.values import TRACKED, Array, Names, SwarmState
from q2q_model.trajectory.flatness import flat_state
from q2q_sim.experiments.validation.drawn_air import MakeDraw
from q2q_sim.experiments.validation.recorded.estimate_noise import estimate_noise
from q2q_sim.experiments.validation.recorded.recorded_law import ReadFlight, feedback
from q2q_sim.experiments.validation.recorded.rotor_drag import drag_acceleration
from q2q_sim.experiments.validation.recorded.tracked_flight import TrackedFlight
from q2q_sim.plant.body.state_row import POS, QUAT, VEL
from q2q_sim.plant.swarm import PHYSICS_RATE


@dataclass(frozen=True, slots=True)
class Draws:
    """Flights of all draws, as their controllers saw and commanded them."""

    pos: Array
    """Measured position [m], world, (draws, T, n, 3)."""
    vel: Array
    """Measured velocity [m/s], world, (draws, T, n, 3)."""
    quat: Array
    """Body to world, (draws, T, n, 4)."""
    thrust: Array
    """Commanded collective thrust [N], (draws, T, n)."""

    def first(self) -> "Draws":
        """Return a copy of the first draw."""
        return Draws(*(values[:1].copy() for values in (self.pos, self.vel, self.quat, self.thrust)))


def redraw_flight(read: ReadFlight, mass: float, make: MakeDraw, seeds: Sequence[int]) -> Draws:
    """Return the flight of vehicles of a mass [kg] flown again once for each seed."""
    flight, law = read.flight, read.law
    ticks, n = flight.thrust.shape
    yaw = yaw_from_quat(flight.quat[0])
    draws = [make(seed, np.column_stack([flight.pos[0], yaw])) for seed in seeds]
    for draw in draws:
        draw.swarm.state[:, VEL] = flight.vel[0]
        draw.swarm.use_attitude_loop(law.attitude)
    noise = [np.stack(parts) for parts in zip(*(estimate_noise(flight, seed) for seed in seeds), strict=True)]
    ahead = flight.ref_acc + law.offset
    expected = _ExpectedDownwash(flight, len(draws))
    steps = round(PHYSICS_RATE * flight.dt)
    integral = np.zeros((len(draws), n, 3))
    seen = Draws(*(np.empty((len(draws), ticks, n, *width)) for width in ((3,), (3,), (4,), ())))
    for k in range(ticks):
        state = np.stack([draw.swarm.state for draw in draws])  # (draws, n, columns)
        pos, vel, quat = state[..., POS] + noise[0][:, k], state[..., VEL] + noise[1][:, k], state[..., QUAT]
        error = flight.ref_pos[k] - pos
        integral += flight.dt * error
        acc = ahead[k] + feedback(law, error, flight.ref_vel[k] - vel, integral)
        acc -= expected.update(k, pos, vel, quat)[..., None] * UP
        command = _command(acc, yaw, mass)
        drag = drag_acceleration(read.drag, state[..., VEL], quat)
        for draw, one, slowed in zip(draws, command, drag, strict=True):
            drive = draw.gusts.step()
            drive[:, :3] += slowed
            draw.swarm.step(np.tile(one, (steps, 1, 1)), drive)
        seen.pos[:, k], seen.vel[:, k], seen.quat[:, k] = pos, vel, quat
        seen.thrust[:, k] = command[..., 0]
    return seen


class _ExpectedDownwash:
    """Downwash that the controllers of all draws expect."""

    def __init__(self, flight: TrackedFlight, draws: int) -> None:
        self._flight, model = flight, flight.model
        self._predictors = [] if model is None else [InteractionPredictor(model) for _ in range(draws)]

    def update(self, k: int, pos: Array, vel: Array, quat: Array) -> Array:
        """Return it in row k [m/s^2], along z, (draws, n), or as recorded, (n,), for states (draws, n, 3)."""
        if not self._predictors:
            return np.asarray(self._flight.compensated[k])
        t, names = k * self._flight.dt, self._flight.names
        states = [_tracked_state(t, names, *one) for one in zip(pos, vel, quat, strict=True)]
        acc = [each.update(state).acc for each, state in zip(self._predictors, states, strict=True)]
        return np.stack(acc)[..., 2]


def _tracked_state(t: float, names: Names, pos: Array, vel: Array, quat: Array) -> SwarmState:
    """Return the state of vehicles that are all tracked, at time t [s]."""
    n = len(names)
    return SwarmState(t, names, pos, vel, quat, np.zeros((n, 3)), np.zeros(n), np.full(n, TRACKED, np.uint8))


def _command(acc: Array, yaw: Array, mass: float) -> Array:
    """Return thrust [N], roll, pitch [rad] and yaw rate [rad/s], (draws, n, 4), for accelerations."""
    attitude = flat_state(acc, np.broadcast_to(yaw, acc.shape[:-1]))
    thrust = mass * attitude.thrust
    return np.stack([thrust, attitude.roll, attitude.pitch, np.zeros_like(thrust)], axis=-1)
