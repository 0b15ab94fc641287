"""Random processes of unit variance in a room's air: the residual of each vehicle, the meander of each jet.

A process is drawn in blocks of one second, ahead of the physics. Each has a random stream of its own, so that
switching one off leaves the others unchanged. Ornstein-Uhlenbeck processes are those of
q2q_sim.ornstein_uhlenbeck.

A recording at 100 Hz is cut and pasted: every block is a random piece of it, interpolated between samples;
during its first 0.1 s the previous piece fades out. Both pieces are weighted by sine and cosine, so that the
variance stays one.
"""

import math

import numpy as np

from q2q_model.compiled import BORROWING, compiled
from q2q_model.signals.values import Array
from q2q_sim.air.room_air import RoomAir
from q2q_sim.ornstein_uhlenbeck import ExactStep, advance_processes, exact_step
from q2q_sim.random_streams import stream

RESIDUAL, MEANDER_X, MEANDER_Y = 0, 1, 2
"""Kinds of processes in a block."""
KINDS = 3
BLOCK_S = 1.0
"""Length of a block [s]."""
RECORDED_HZ = 100.0
"""Rate of a recorded residual [1/s]."""
FADE_S = 0.1
"""Overlap of two pieces [s]."""


@compiled(**BORROWING)
def filter_noise(noise: Array, last: Array, weights: ExactStep) -> None:
    """Turn white noise (steps, n) in place into Ornstein-Uhlenbeck processes that go on from `last` (n,)."""
    for k in range(noise.shape[0]):
        advance_processes(last, noise[k], weights)
        for i in range(last.size):
            noise[k, i] = last[i]


class OrnsteinUhlenbeck:
    """Independent Ornstein-Uhlenbeck processes of unit variance."""

    def __init__(self, rng: np.random.Generator, count: int, step: float, time: float) -> None:
        """Draw the first values; `step` and the correlation time `time` are in [s]."""
        self._rng = rng
        self._last = rng.standard_normal(count)
        self._weights = exact_step(step, time)

    def block(self, steps: int) -> Array:
        """Return the next `steps` values, (steps, count)."""
        values = self._rng.standard_normal((steps, len(self._last)))
        filter_noise(values, self._last, self._weights)
        return values


class PlayedBack:
    """Random pieces of a recording, one series for each vehicle."""

    def __init__(self, rng: np.random.Generator, count: int, step: float, recording: Array) -> None:
        """Cut the first pieces; `step` is in [s]."""
        self._rng, self._count, self._recording = rng, count, recording
        self._each = step * RECORDED_HZ
        self._fade = round(FADE_S / step)
        self._tail = np.zeros((0, count))

    def block(self, steps: int) -> Array:
        """Return the next `steps` values, (steps, count)."""
        fade = min(self._fade, steps)
        last = len(self._recording) - 1 - (steps + fade) * self._each
        begin = self._rng.uniform(0.0, last, self._count)
        at = begin + self._each * np.arange(steps + fade)[:, None]  # (steps + fade, count)
        piece = np.interp(at, np.arange(len(self._recording)), self._recording)
        if len(self._tail):
            piece[:fade] = cross_fade(self._tail, piece[:fade])
        self._tail = piece[steps:].copy()
        return np.asarray(piece[:steps])


def cross_fade(before: Array, after: Array) -> Array:
    """Return a piece (k, n) that fades out into another, (k, n), both of unit variance."""
    angle = 0.5 * math.pi * (np.arange(len(after))[:, None] + 0.5) / len(after)
    return np.asarray(np.sin(angle) * after + np.cos(angle) * before)


def block_steps(step: float) -> int:
    """Return the number of steps of `step` [s] in a block."""
    return round(BLOCK_S / step)


class UnitProcesses:
    """Processes of a flight in a room's air."""

    def __init__(self, air: RoomAir, count: int, step: float, seed: int) -> None:
        """Prepare the processes of `count` vehicles; `step` is in [s]."""
        self._residual: OrnsteinUhlenbeck | PlayedBack | None = None
        self._meander: OrnsteinUhlenbeck | None = None
        if air.residual is not None:
            rng = stream(seed, "air residual")
            if air.residual.recording is None:
                self._residual = OrnsteinUhlenbeck(rng, count, step, air.residual.time_s)
            else:
                self._residual = PlayedBack(rng, count, step, air.residual.recording)
        if air.meander is not None:
            rng = stream(seed, "air meander")
            self._meander = OrnsteinUhlenbeck(rng, 2 * count, step, air.meander.time_s)

    def fill(self, block: Array) -> None:
        """Write the next block (KINDS, steps, n)."""
        steps, count = block.shape[1:]
        if self._residual is not None:
            block[RESIDUAL] = self._residual.block(steps)
        if self._meander is not None:
            block[MEANDER_X:] = np.moveaxis(self._meander.block(steps).reshape(steps, count, 2), 2, 0)
