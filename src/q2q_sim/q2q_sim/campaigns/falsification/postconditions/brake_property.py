"""What the guard states of vehicles without measurements (q2q_control.failsafe.tracking_loss): they brake.

| violation | statement that it breaks |
|---|---|
| brake | a vehicle that levels or lands without measurements faster than FAST is decelerated |

It was known to be as fast, in the same direction, when it was last measured, is so at the command, and
nothing has deceived its dead reckoning since (hidden_motion). With v its true horizontal velocity once the
command has taken effect:

    -a . v / |v|  >=  SHARE min(|v| / tau, a_max)      where  |v|, v_c . v / |v|, v_m . v / |v| > FAST

Below FAST the deceleration due is that of FAST. Longer than DRIFT_FROM_S after its last measurement a
vehicle may drift unnoticed by DRIFT (descent_evasion): FAST is larger by as much then. The margin is that
of an implication, as in signal temporal logic (Fainekos and Pappas, 2009): the larger one of how far the
vehicle is from being fast and how far the deceleration is from its limit, at most 1. So a search is led to
where a vehicle is lost at speed and is not braked.

| symbol | name | meaning [unit] |
|---|---|---|
| a | acc | horizontal acceleration that the commanded tilt asks for [m/s^2] |
| v, v_c, v_m | vel, earlier | true velocities LAG_S after the command, at it, and when last measured [m/s] |
| tau, a_max | BRAKING_S, BRAKING_MAX | [s], [m/s^2] (braking_law) |
"""

from typing import NamedTuple

import numpy as np

from q2q_control.failsafe.evasion.descent_evasion import DRIFT, DRIFT_FROM_S
from q2q_control.failsafe.tracking_loss.braking_law import BRAKING_MAX, BRAKING_S
from q2q_control.failsafe.tracking_loss.dead_reckoned_braking import levels_or_lands
from q2q_control.failsafe.tracking_loss.dead_reckoning import LAG_S
from q2q_model.signals.stamps import TICK_S
from q2q_model.signals.values import Array, Mask
from q2q_sim.campaigns.falsification.postconditions.hidden_motion import (
    after_late_frame,
    after_rotor_change,
    hidden_by_air,
    in_ignored_downwash,
    last_measured,
    misleading_measurement,
)
from q2q_sim.campaigns.falsification.postconditions.postcondition_outcome import PostconditionOutcome
from q2q_sim.campaigns.falsification.postconditions.run_ticks import RunTicks, over_ticks
from q2q_sim.campaigns.random_runs.random_run import Run
from q2q_sim.monitors.policies import Violation

FAST = 0.4
"""Speed from which braking is judged [m/s]: the reckoned one may be wrong by (1 - SHARE) of it, 0.3 m/s."""
SHARE = 0.25
"""Minimum share of the braking that the true speed asks for [-]."""
STILL = 1e-9
"""Speed that has no direction [m/s]."""


class _Braking(NamedTuple):
    """Braking of every tick and vehicle, (T, n)."""

    speed: Array
    """True speed once the command has taken effect, or that along it at the command or when last measured,
    whichever is least [m/s]."""
    fast: Array
    """Speed from which braking is judged [m/s]."""
    share: Array
    """Commanded deceleration, of that due [-]."""


def brake(run: Run, ticks: RunTicks) -> PostconditionOutcome:
    """Return the vehicle without measurements that is braked the least."""
    found = _braking(ticks)
    judged = _judged(run, ticks)[: len(found.speed)]
    unmet = np.where(judged & (found.speed > found.fast), found.share, np.inf)
    k, row = np.unravel_index(int(unmet.argmin()), unmet.shape)
    least = float(unmet[k, row])
    bad = (Violation("brake", ticks.names[row], float(ticks.t[k]), least, SHARE),) if least < SHARE else ()
    margin = np.maximum(1.0 - found.speed / found.fast, found.share / SHARE - 1.0)
    return PostconditionOutcome(bad, float(np.minimum(margin[judged], 1.0).min(initial=np.inf)))


def _braking(ticks: RunTicks) -> _Braking:
    """Return the braking of the ticks whose commands take effect within the flight."""
    late = round(LAG_S / TICK_S)
    true_vel = over_ticks(ticks.truth, "vel")[..., :2]
    vel = true_vel[late:]
    speed = np.linalg.norm(vel, axis=2)
    along = vel / np.maximum(speed, STILL)[..., None]
    last = last_measured(ticks)[: len(vel)]
    before = np.take_along_axis(true_vel, last[..., None], axis=0)
    known = speed  # a push since it was measured is unknown, and who is measured again may speed up
    for earlier in (before, true_vel[: len(vel)]):
        known = np.minimum(known, np.einsum("tnk,tnk->tn", earlier, along))
    age = TICK_S * (np.arange(len(vel))[:, None] - last)
    fast = np.where(age > DRIFT_FROM_S, FAST + DRIFT, FAST)
    due = np.minimum(np.maximum(speed, FAST) / BRAKING_S, BRAKING_MAX)
    return _Braking(known, fast, -np.einsum("tnk,tnk->tn", ticks.commanded_acc()[: len(vel)], along) / due)


def _judged(run: Run, ticks: RunTicks) -> Mask:
    """Return where a vehicle levels or lands and nothing hides its motion from dead reckoning, (T, n)."""
    faults = run.scenario.faults
    hidden = (
        misleading_measurement(ticks, faults)
        | after_late_frame(ticks, faults)
        | after_rotor_change(ticks, faults)
    )
    hidden |= in_ignored_downwash(ticks, aware=run.options.aware) | hidden_by_air(run, ticks)
    return np.asarray(levels_or_lands(ticks.command_status) & ~hidden)
