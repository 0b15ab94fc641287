"""Fly by the explicit law: height by the distilled horizon, position by the PID's law.

Each vehicle looks at itself and at the neighbour whose draft along the horizon is the largest between them
(q2q_control.explicit.features); one that no draft touches gets a pair far away. What the observer finds
unexplained is taken off the command, so that an offset does not stay.

Everything a vehicle needs is its own state, its neighbour's, and both references: distributed, no solver.
"""

import numpy as np

from q2q_control.alignment import (
    ETA,
    POS,
    REF_ACC,
    REF_POS,
    REF_VEL,
    VEL,
    Aligned,
    align,
)
from q2q_control.disturbance_tracker import DisturbanceTracker, TrackerParams
from q2q_control.explicit.features import WHEN, features
from q2q_control.explicit.law import ExplicitLaw, evaluate_one, packed
from q2q_control.pid import PidParams, pid_limits
from q2q_control.pid_kernel import command_rows, packed_numbers
from q2q_control.preview import ReferencePreview, shifted_preview
from q2q_control.row_memory import HoldThenLevel, RowMemory
from q2q_model.interaction.model import InteractionModel, at_rest
from q2q_model.signals import Array, Interference, SwarmCommand, SwarmSetpoint, SwarmState
from q2q_model.vehicle import Vehicle

AWAY = np.array([50.0, 0.0, 0.5])
"""Where the neighbour of a vehicle without one is taken to be [m]."""


class ExplicitController:
    """Hold the law, the estimates and the last commands."""

    def __init__(
        self,
        law: ExplicitLaw,
        settings: tuple[PidParams, TrackerParams],
        vehicle: Vehicle,
        model: InteractionModel,
    ) -> None:
        """Control vehicles like `vehicle`: height by `law`, x, y, yaw and limits by the PID's parameters."""
        self._weights, self._sizes = packed(law)
        self._scratch = np.empty(int(self._sizes.sum()))
        self._params, self._model = settings[0], model
        limits = pid_limits(settings[0], vehicle)
        yaw = (settings[0].k_yaw, settings[0].yaw_rate_max)
        self._numbers = packed_numbers(np.zeros((4, 3)), limits, yaw)
        self._tracker = DisturbanceTracker(settings[1], vehicle)
        hover = min(vehicle.hover_thrust, limits.thrust_max)
        self._rows = RowMemory(HoldThenLevel(settings[0].hold_time, hover))
        self._last: SwarmCommand | None = None
        self.preview: ReferencePreview | None = None
        """Where the references will go; None lets each setpoint go on by itself."""

    def reset(self) -> None:
        """Forget all memory."""
        self._tracker.reset()
        self._rows.reset()
        self._last = None

    def update(
        self, state: SwarmState, setpoint: SwarmSetpoint, interference: Interference | None
    ) -> SwarmCommand:
        """Return the tick's command; `interference` None means ignoring the draft."""
        last = self._last
        if last is not None and last.t == setpoint.t and last.names == setpoint.names:
            return last
        if last is not None and setpoint.t < last.t:
            self.reset()
        tick = align(state, setpoint, interference)
        estimate = self._tracker.update(tick, state).estimate
        known = tick.usable[:, None]
        tick.table[:, POS] = np.where(known, estimate.pos, tick.table[:, POS])
        tick.table[:, VEL] = np.where(known, estimate.vel, tick.table[:, VEL])
        ahead = shifted_preview(setpoint, self.preview, setpoint.t + WHEN)[..., :3]
        acc = self._acceleration(tick, ahead, aware=interference is not None)
        self._last = self._command(tick, acc - np.where(known, estimate.disturbance, 0.0))
        self._tracker.sent(self._last, tick)
        return self._last

    def _acceleration(self, tick: Aligned, ahead: Array, *, aware: bool) -> Array:
        """Return the wanted accelerations [m/s^2], world, (n, 3); `ahead` (n, M, 3) are the references."""
        table, params = tick.table, self._params
        off, rate = table[:, POS] - table[:, REF_POS], table[:, VEL] - table[:, REF_VEL]
        acc = table[:, REF_ACC] - params.k_p_xy * off - params.k_d_xy * rate - table[:, ETA]
        other = self._neighbours(tick, ahead) if aware else np.full(len(ahead), -1)
        alone = (other < 0)[:, None]
        errors = np.column_stack([off[:, 2], rate[:, 2], off[other, 2], rate[other, 2]])
        errors[:, 2:] = np.where(alone, 0.0, errors[:, 2:])
        second = np.where(alone[..., None], ahead + AWAY, ahead[other])
        looked_at = features(errors, np.stack([ahead, second], axis=1), self._model)
        for row, x in enumerate(looked_at):
            lift = evaluate_one(self._weights, self._sizes, x, self._scratch)
            acc[row, 2] = table[row, REF_ACC.start + 2] + lift
        return np.asarray(acc)

    def _neighbours(self, tick: Aligned, ahead: Array) -> Array:
        """Return the row of each vehicle's strongest neighbour, -1 where none, (n,)."""
        n = len(ahead)
        rel = ahead[None] - ahead[:, None]  # (feels, causes, M, 3)
        strength = np.abs(self._model.acceleration(rel, at_rest(rel))[..., 2]).max(axis=-1)
        strength = strength + strength.T
        strength[~tick.usable] = strength[:, ~tick.usable] = 0.0
        strength[np.arange(n), np.arange(n)] = 0.0
        return np.asarray(np.where(strength.max(axis=1) > 0.0, strength.argmax(axis=1), -1))

    def _command(self, tick: Aligned, acc: Array) -> SwarmCommand:
        values, saturated = command_rows(acc, tick.table, self._numbers)
        return self._rows.completed(tick, values, saturated)
