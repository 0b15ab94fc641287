"""Preview of the references, for predictive controllers.

The preview is a table sampled from the plan; without a plan, each setpoint is extrapolated at its velocity,
which decays. A replanner moves setpoints off the plan: `shifted_preview` shifts the plan by a small
difference, which decays in a second. A setpoint far off its plan, or on its way there, as one that is kept
out of a zone the plan passes through, is extrapolated:

    preview = w shifted + (1 - w) extrapolated,     w = exp(-(d^2 + (STEADY d')^2) / AWAY^2)
    d, d': setpoint to plan [m], [m/s]
    extrapolated: a(s) = a exp(-s / STEADY), v and r its integrals
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from q2q_control.inputs.shifted_setpoint import ShiftedSetpoint
from q2q_model.compiled import compiled
from q2q_model.signals.values import Array, Names, SwarmSetpoint, rows_by_name

OFF_PLAN_FADE = 1.0
"""Time constant of a difference between setpoint and plan [s]: above the replanner's k_d / k_p = 0.6 s."""
SAME = 1e-6
"""A setpoint as near as this to its plan [SI] has not been moved: tables are interpolated linearly."""
AWAY = 0.03
"""Distance from its plan, now or within STEADY, beyond which a setpoint does not follow it [m]: less than a
vehicle is off its setpoint in calm flight."""
STEADY = 0.3
"""Time constant of a moved setpoint's acceleration [s]: half the replanner's k_d / k_p."""
COAST = 0.5
"""Time constant of the velocity of a setpoint without plan [s]."""


class ReferencePreview(Protocol):
    """Source of the future references of named vehicles."""

    def at(self, names: Names, times: Array) -> Array:
        """Return position [m], velocity [m/s], acceleration [m/s^2], world, at `times` (K,) [s], (n, K, 9).

        Rows of unknown vehicles are NaN.
        """


@dataclass(frozen=True, slots=True)
class SampledPreview:
    """Plan sampled at equal steps, at rest before its start and after its end."""

    names: Names
    start: float
    """Time of the first sample [s]."""
    step: float
    """[s]; at 0.01 s linear interpolation errs by 12 um at 1 m/s^2."""
    samples: Array
    """Position, velocity, acceleration, (n, T, 9)."""

    def at(self, names: Names, times: Array) -> Array:
        """Return the samples at `times`, linearly interpolated, (n, K, 9)."""
        known = interpolated(self.samples, times, self.start, self.step)
        return known if names == self.names else rows_by_name(known, self.names, names, np.nan)


def resting_preview(names: Names) -> SampledPreview:
    """Return a preview in which all vehicles rest at the origin, for a warm-up before a plan arrives."""
    return SampledPreview(names, 0.0, 1.0, np.zeros((len(names), 2, 9)))


def shifted_preview(setpoint: SwarmSetpoint, preview: ReferencePreview | None, times: Array) -> Array:
    """Return the references of the setpoint's vehicles at `times` (K,) [s], (n, K, 9).

    At the setpoint's own time, position and velocity are the setpoint's; its difference from the plan decays,
    but for a shift that is known ahead.
    """
    here = np.empty((len(setpoint.names), 9))  # one layout, whatever the signal's
    np.concatenate((setpoint.pos, setpoint.vel, setpoint.acc), axis=1, out=here)
    asked = np.empty(times.size + 1)
    asked[0], asked[1:] = setpoint.t, times
    if not isinstance(setpoint, ShiftedSetpoint):
        return _ahead(here, setpoint.names, preview, asked)
    shift = setpoint.shift_at(asked)
    return _ahead(here - shift[:, 0], setpoint.names, preview, asked) + shift[:, 1:]


def _ahead(here: Array, names: Names, preview: ReferencePreview | None, asked: Array) -> Array:
    """Return the references (n, K, 9) at `asked` (1 + K,) [s] but the first, the time of `here` (n, 9)."""
    plan = preview.at(names, asked) if preview is not None else None
    if plan is not None and is_on_plan(here, plan):
        return plan[:, 1:]
    ahead = (asked[1:] - asked[0])[:, None]
    return _coasting(here, ahead) if plan is None else _off_plan(here, plan, ahead)


def _off_plan(here: Array, plan: Array, ahead: Array) -> Array:
    """Return the references of setpoints (n, 9) moved off their plan (n, 1 + K, 9), `ahead` (K, 1) [s]."""
    off = here - plan[:, 0]
    fade = np.exp(-ahead / OFF_PLAN_FADE)
    shifted = plan[:, 1:].copy()
    shifted[..., :3] += (off[:, None, :3] + off[:, None, 3:6] * ahead) * fade
    shifted[..., 3:6] += off[:, None, 3:6] * fade
    leaving = np.sum(off[:, :3] ** 2 + (STEADY * off[:, 3:6]) ** 2, axis=1)
    share = np.exp(-leaving / AWAY**2)[:, None, None]
    shifted = share * shifted + (1.0 - share) * _extrapolated(here, ahead)
    if np.isfinite(off).all():
        return np.asarray(shifted)
    unknown = np.isnan(plan.sum(axis=(1, 2)))
    return np.where(unknown[:, None, None], _coasting(here, ahead), shifted)


def _coasting(here: Array, ahead: Array) -> Array:
    gone = COAST * -np.expm1(-np.maximum(ahead, 0.0) / COAST)  # (K, 1): distance over velocity
    pos = here[:, None, :3] + here[:, None, 3:6] * gone
    vel = here[:, None, 3:6] * np.exp(-np.maximum(ahead, 0.0) / COAST)
    return np.concatenate([pos, vel, -vel / COAST], axis=-1)


def _extrapolated(here: Array, ahead: Array) -> Array:
    pos, vel, acc = here[:, None, :3], here[:, None, 3:6], here[:, None, 6:9]
    later = np.maximum(ahead, 0.0)
    fade = np.exp(-later / STEADY)
    gained = STEADY * (1.0 - fade)  # (K, 1): velocity over acceleration
    return np.concatenate(
        [pos + vel * later + acc * STEADY * (later - gained), vel + acc * gained, acc * fade], axis=-1
    )


@compiled
def is_on_plan(here: Array, plan: Array) -> bool:
    """Return whether setpoints (n, 9) differ by less than SAME from the start of their plan (n, 1 + K, 9)."""
    for v in range(here.shape[0]):
        for c in range(here.shape[1]):
            if not abs(here[v, c] - plan[v, 0, c]) < SAME:  # or not a number
                return False
    return True


@compiled
def interpolated(samples: Array, times: Array, start: float, step: float) -> Array:
    """Return samples (n, T, c), `step` apart from `start` on [s], linearly interpolated at times (K,) [s].

    Times before the first sample or after the last one get that sample, (n, K, c).
    """
    last = samples.shape[1] - 1
    found = np.empty((samples.shape[0], times.size, samples.shape[2]))
    for k in range(times.size):
        place = min(max((times[k] - start) / step, 0.0), float(last))
        before = min(int(place), max(last - 1, 0))
        after, share = min(before + 1, last), place - before
        for v in range(samples.shape[0]):
            for c in range(samples.shape[2]):
                found[v, k, c] = samples[v, before, c] * (1.0 - share) + samples[v, after, c] * share
    return found
