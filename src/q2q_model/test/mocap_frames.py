"""Frames of two vehicles in smooth motion, for tests of the mocap filter."""

import numpy as np

from q2q_model.estimation.mocap_filter import MocapFilter
from q2q_model.estimation.mocap_filter_params import MocapFilterParams
from q2q_model.geometry.rotations import identity_quat
from q2q_model.signals.values import Array, MocapFrame, Names, SwarmState, TrackStatus

STEP_NS = 10_000_000
PAIR: Names = ("cf1", "cf2")
IDEAL_SENSING = MocapFilterParams(position_noise=0.0, rate_filter_s=0.0)
"""For noise-free simulated mocap: positions pass through, velocities are accurate to 4e-5 m/s."""
COAST_S = IDEAL_SENSING.coast_s
TRACKED, COASTING, LOST = TrackStatus.TRACKED, TrackStatus.COASTING, TrackStatus.LOST


def time_of(tick: int) -> float:
    return tick * STEP_NS * 1e-9


def truth_at(tick: int) -> tuple[Array, Array]:
    """Return position and velocity of two vehicles whose acceleration swings by 0.5 m/s^2 in 3 s."""
    w = 2.0 * np.pi / 3.0
    phase = w * time_of(tick) + np.array([[0.0, 1.0, 2.0], [1.0, 2.0, 3.0]])
    base = np.array([[0.0, 0.0, 1.0], [0.0, 0.3, 1.6]])
    return base + 0.5 / w**2 * np.sin(phase), 0.5 / w * np.cos(phase)


def frame_at(tick: int, pos: Array | None = None, quat: Array | None = None) -> MocapFrame:
    pos = truth_at(tick)[0] if pos is None else pos
    return MocapFrame(
        time_of(tick), PAIR[: len(pos)], pos, identity_quat((len(pos),)) if quat is None else quat
    )


def flown_until(until: int, params: MocapFilterParams = IDEAL_SENSING) -> MocapFilter:
    """Return a filter that has seen the ticks 0 .. until - 1."""
    block = MocapFilter(params, PAIR)
    for tick in range(until):
        block.update(frame_at(tick))
    return block


def same(a: SwarmState, b: SwarmState) -> bool:
    return a.names == b.names and all(
        np.array_equal(getattr(a, name), getattr(b, name))
        for name in ("t", "pos", "vel", "quat", "ang_vel_body", "age", "status")
    )
