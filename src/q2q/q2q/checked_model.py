"""Interaction model of a user's class, with every output checked."""

import math

import numpy as np

from q2q_model.downwash.interaction_model import (
    InteractionModel,
    ModelOutputError,
    PairMotion,
    Reach,
    pairs_at_rest,
)
from q2q_model.geometry.pair_reach import beyond_reach
from q2q_model.geometry.rotations import UP
from q2q_model.signals.checked_array import checked_array, own_copy
from q2q_model.signals.stamps import SAME_INSTANT
from q2q_model.signals.values import Array, Mask
from q2q_sim.air.checked_wake import LARGEST_ACC

NEEDED = {
    "delay": "must be finite and at least 0 s",
    "acceleration": f"must be finite and at most {LARGEST_ACC:g} m/s^2 in magnitude",
    "deviation": f"must be in [0, {LARGEST_ACC:g}] m/s^2, or NaN where unknown",
}
"""Outputs that are allowed, by method."""
PLACES = np.array([[aside, 0.0, gap] for aside in (0.0, 0.1, 1.0) for gap in (-1.0, -0.3, 0.3, 1.0)])
"""Sources of the trial, from the vehicle that feels them [m], (12, 3)."""
VEL = np.array([0.5, -0.5, 0.2])
"""Velocity of all vehicles in half of the trial [m/s]."""


class CheckedModel:
    """Model that raises ModelOutputError where its class returns something that cannot be flown with."""

    def __init__(self, model: InteractionModel) -> None:
        """Take a model, and try it with pairs at rest, as a predictor asks, and in motion, as an MPC does."""
        self._model = model
        self._name = f"model {type(model).__module__}:{type(model).__qualname__}"
        self._reach, self._max_delay = self._checked_reach(), self._checked_max_delay()
        vel, axis = (np.tile(one, (len(PLACES), 1)) for one in (VEL, UP))
        moving = PairMotion(source_vel=vel, source_axis=axis, vel=vel)
        for rel_pos, motion in ((PLACES, pairs_at_rest(PLACES)), (np.stack([PLACES, 2.0 * PLACES]), moving)):
            self.delay(rel_pos)
            self.acceleration(rel_pos, motion)
            self.deviation(rel_pos, motion)

    @property
    def reach(self) -> Reach:
        """Return the range of the downwash, as the model gave it first."""
        return self._reach

    @property
    def max_delay(self) -> float:
        """Return the largest transport delay [s], as the model gave it first."""
        return self._max_delay

    def delay(self, rel_pos: Array) -> Array:
        """Return the model's transport delay [s], (...,)."""
        given = self._numbers("delay", self._model.delay(rel_pos.copy()), rel_pos.shape[:-1])
        self._require("delay", given, (given >= 0.0) & (given < math.inf), (rel_pos,))
        far = beyond_reach(rel_pos, rel_pos, (self._reach.horizontal, self._reach.vertical))
        needed = f"must be at most max_delay = {self._max_delay:g} s within reach"
        self._require("delay", given, far | (given <= self._max_delay + SAME_INSTANT), (rel_pos,), needed)
        return given

    def acceleration(self, rel_pos: Array, motion: PairMotion) -> Array:
        """Return the model's eta [m/s^2], world, (..., 3)."""
        given = self._numbers(
            "acceleration", self._model.acceleration(rel_pos.copy(), own_copy(motion)), rel_pos.shape
        )
        allowed = np.abs(given) <= LARGEST_ACC  # not NaN either
        inputs = rel_pos, motion.source_vel, motion.source_axis, motion.vel
        self._require("acceleration", given, np.asarray(allowed.all(axis=-1)), inputs)
        return given

    def deviation(self, rel_pos: Array, motion: PairMotion) -> Array:
        """Return one standard deviation of the model's prediction [m/s^2], (..., 3)."""
        given = self._numbers(
            "deviation", self._model.deviation(rel_pos.copy(), own_copy(motion)), rel_pos.shape
        )
        allowed = np.isnan(given) | ((given >= 0.0) & (given <= LARGEST_ACC))
        self._require("deviation", given, np.asarray(allowed.all(axis=-1)), (rel_pos,))
        return given

    def _checked_reach(self) -> Reach:
        reach = self._model.reach
        if isinstance(reach, Reach) and _is_length(reach.horizontal) and _is_length(reach.vertical):
            return reach
        raise ModelOutputError(f"{self._name}: reach is {reach!r}; must be a Reach of finite distances [m]")

    def _checked_max_delay(self) -> float:
        longest = self._model.max_delay
        if _is_length(longest):
            return float(longest)
        raise ModelOutputError(f"{self._name}: max_delay is {longest!r}; must be a finite time [s]")

    def _numbers(self, what: str, output: object, shape: tuple[int, ...]) -> Array:
        try:
            return np.ascontiguousarray(checked_array(output, shape), dtype=np.float64)
        except ValueError as error:
            raise ModelOutputError(f"{self._name}: {what} {error}") from error

    def _require(
        self, what: str, given: Array, allowed: Mask, inputs: tuple[Array, ...], needed: str = ""
    ) -> None:
        """Raise ModelOutputError for the first pair of finite inputs whose output is not allowed."""
        if allowed.all():
            return
        finite = np.broadcast_arrays(*(np.isfinite(one).all(axis=-1) for one in inputs))
        wrong = np.flatnonzero(~allowed & np.logical_and.reduce(finite))
        if wrong.size:
            pair = int(wrong[0])
            rel_pos, value = (one.reshape(allowed.size, -1)[pair] for one in (inputs[0], given))
            there = f"{what} for a source at rel_pos {rel_pos} m is {value}"
            raise ModelOutputError(f"{self._name}: {there}; {needed or NEEDED[what]}", pair)


def _is_length(value: object) -> bool:
    """Return whether a distance or a time is a finite number that is not negative."""
    return isinstance(value, int | float | np.integer | np.floating) and 0.0 <= float(value) < math.inf
