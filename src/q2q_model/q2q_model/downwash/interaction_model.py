"""Interface of an interaction model: the downwash law of one pair and its transport delay.

eta_i(t) = sum over j of law(r_j(t - tau) - r_i(t), v_j(t - tau), b_j(t - tau), v_i(t)),
tau = delay(r_j(t) - r_i(t)),

with b the body z axis: rotors drive air along -b, so a tilted source deflects its downwash.

Vehicle i is exposed to the downwash of source j; rel_pos = pos_j - pos_i, so a source above has rel_pos
z > 0. Laws take arrays of pairs of any batch shape and are stateless. `retarded_pairs` applies the delay for
all callers, which differ in what they know of a source's past:

| caller | past of a source |
|---|---|
| q2q_model.downwash.predictor | states received |
| q2q_model.identification.push.along_flight | the recorded flight |
| q2q_control.mpc.prediction.downwash_horizon | positions received, then the predicted path |
| q2q_control.explicit_mpc.teacher | constant velocity |
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol, Self, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from q2q_model.geometry.pair_reach import beyond_reach
from q2q_model.geometry.rotations import UP
from q2q_model.signals.values import Array, Mask


@dataclass(frozen=True, slots=True)
class Reach:
    """Distances beyond which a pair has no downwash, by the rule of q2q_model.geometry.pair_reach.

    A law may still be large there: `measured_law` has 1.2 m/s^2 at its range.
    """

    horizontal: float
    """[m]; a law should be negligible here, as sources move and lean."""
    vertical: float
    """[m]"""


EDGE = 4.3
"""Standard deviations at which a Gaussian has fallen to 1e-4."""


@dataclass(frozen=True, slots=True)
class PairMotion:
    """Motion of pairs: of the source at the time its air left it, of the exposed vehicle now."""

    source_vel: Array
    """Velocity of j [m/s], world, (..., 3)."""
    source_axis: Array
    """Body z of j, unit length, world, (..., 3)."""
    vel: Array
    """Velocity of i [m/s], world, (..., 3)."""


@dataclass(frozen=True, slots=True)
class RetardedPairs:
    """Pairs whose sources are as when their air left them."""

    rel_pos: Array
    """r_j(t - tau) - r_i(t) [m], world, (..., 3)."""
    motion: PairMotion
    now: Array
    """r_j(t) - r_i(t) [m], world, (..., 3)."""


@dataclass(frozen=True, slots=True)
class SourceStates:
    """States of the sources of pairs."""

    pos: Array
    """[m], world, (..., 3)."""
    vel: Array
    """[m/s], world, (..., 3)."""
    axis: Array
    """Body z, unit length, world, (..., 3)."""

    @classmethod
    def of_rows(cls, rows: Array) -> Self:
        """Return the states in rows of position, velocity and axis, (k, 9)."""
        return cls(rows[:, :3], rows[:, 3:6], rows[:, 6:])


def pairs_at_rest(rel_pos: Array) -> PairMotion:
    """Return the motion of level vehicles at rest, one pair for each relative position (..., 3)."""
    still = np.zeros_like(rel_pos)
    return PairMotion(source_vel=still, source_axis=still + UP, vel=still)


class ModelOutputError(ValueError):
    """Error for an output of a model that cannot be flown with."""

    def __init__(self, message: str, pair: int | None = None) -> None:
        """Take the message, and the number of the pair if the output for one is wrong."""
        super().__init__(message)
        self.pair = pair


@runtime_checkable
class InteractionModel(Protocol):
    """Model of the downwash of one source at one vehicle."""

    @property
    def reach(self) -> Reach:
        """Return where the downwash ends."""

    @property
    def max_delay(self) -> float:
        """Return the largest transport delay [s]; 0 for a model without delay."""

    def delay(self, rel_pos: Array) -> Array:
        """Return the transport delay tau [s], (...,), of downwash from a source at rel_pos [m], (..., 3)."""

    def acceleration(self, rel_pos: Array, motion: PairMotion) -> Array:
        """Return the law's eta [m/s^2], world, (..., 3), of retarded pairs, also of those beyond the reach.

        `downwash` ends there.

        Args:
            rel_pos: relative position [m], world, (..., 3).
            motion: of the pairs; its arrays broadcast to rel_pos.
        """

    def deviation(self, rel_pos: Array, motion: PairMotion) -> Array:
        """Return one standard deviation of the prediction [m/s^2], (..., 3); NaN where unknown."""


def retarded_pairs(
    model: InteractionModel, pos: Array, vel: Array, now: SourceStates, past: Callable[[Array], SourceStates]
) -> RetardedPairs:
    """Return pairs whose sources are as when their air left them.

    Args:
        model: gives the delay.
        pos: of the exposed vehicles [m], world, (..., 3).
        vel: of the exposed vehicles [m/s], world, (..., 3).
        now: present sources, with which the delay is computed.
        past: returns the sources a delay [s], (...,), ago; not called for a model without delay.
    """
    present = now.pos - pos
    if model.max_delay == 0.0:
        return RetardedPairs(present, PairMotion(now.vel, now.axis, vel), present)
    left = past(model.delay(present))
    return RetardedPairs(left.pos - pos, PairMotion(left.vel, left.axis, vel), present)


def downwash_ended(pairs: RetardedPairs, reach: Reach) -> Mask:
    """Return which pairs are beyond a model's reach, (...,)."""
    return beyond_reach(pairs.rel_pos, pairs.now, (reach.horizontal, reach.vertical))


def downwash(model: InteractionModel, pairs: RetardedPairs) -> Array:
    """Return eta of pairs [m/s^2], world, (..., 3)."""
    law = model.acceleration(pairs.rel_pos, pairs.motion)
    return np.where(downwash_ended(pairs, model.reach)[..., None], 0.0, law)


def downwash_at_rest(model: InteractionModel, rel_pos: ArrayLike) -> Array:
    """Return eta of level vehicles at rest [m/s^2], world, (..., 3), for relative positions [m], (..., 3).

    Raises:
        ValueError: the last axis is not 3 long.
    """
    apart = np.asarray(rel_pos, dtype=np.float64)
    if apart.shape[-1:] != (3,):
        raise ValueError(f"rel_pos of shape {apart.shape} is given; must be (..., 3)")
    return downwash(model, RetardedPairs(apart, pairs_at_rest(apart), apart))
