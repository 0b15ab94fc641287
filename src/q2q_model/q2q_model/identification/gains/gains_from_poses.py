"""Gains of the altitude loop where no commands were recorded, and whether poses show them.

Any motion is fitted best by some loop. One that does not damp fits noise and gusts, and one of vehicles that
stay at their references fits anything. Gains are known if the loop explains what vehicles deviate from their
references, sum dev^2, up to a tenth, and K_d is above 0; else their intervals are all that was searched.

Nor is it known whether thrust lags, and whether the controller integrates: intervals hold those of the fits
without lag and with the most that it may be, without and with an integral. An offset is fitted if it is
significantly better.
"""

from collections.abc import Sequence

from q2q_model.identification.gains.altitude_record import AltitudeRecord
from q2q_model.identification.gains.command_gains import GainFit
from q2q_model.identification.gains.trajectory_gains import (
    HIGH,
    INTEGRAL,
    OFFSET,
    TrajectoryGains,
    gains_from_trajectories,
    is_better,
)
from q2q_model.identification.intervals import Interval
from q2q_model.vehicle.constants import Vehicle

EXPLAINED = 0.9
"""Share of the mean square deviation that a loop must explain for its gains to be known [-]. In
simulated flights with gusts, noise, downwash, integrals and lag, intervals above it hold the flown gains."""
DELAY = 0.02
"""Most that motion capture, radio and sampling delay a command in addition to the thrust lag [s]."""


def gains_from_poses(records: Sequence[AltitudeRecord], vehicle: Vehicle) -> tuple[GainFit, list[str]]:
    """Return the loop that predicts altitudes best, with intervals of its gains, and notes."""
    found, options = _best(records)
    most_lag, fits = vehicle.thrust_lag + DELAY, [found]
    if _shows_loop(found):
        fits.append(gains_from_trajectories(records, options, most_lag))
    shown = all(_shows_loop(one) for one in fits)
    if shown:
        integral = [gains_from_trajectories(records, (INTEGRAL,), lag) for lag in (0.0, most_lag)]
        fits += [one for one in integral if one.explained >= EXPLAINED]
    k_p, k_d = (_joined(name, fits) if shown else _unknown(name, found) for name in ("k_p", "k_d"))
    fit = GainFit(
        loop=found.loop,
        k_p=k_p,
        k_d=k_d,
        needs_offset=OFFSET in options,
        needs_integral=False,
        rms=found.rms,
        from_commands=False,
    )
    return fit, [] if fit.holds else [_unshown_note(found)]


def _best(records: Sequence[AltitudeRecord]) -> tuple[TrajectoryGains, tuple[str, ...]]:
    """Return the fit with an offset if that is significantly better, and its options."""
    found, shifted = gains_from_trajectories(records), gains_from_trajectories(records, (OFFSET,))
    return (shifted, (OFFSET,)) if is_better(shifted, found) else (found, ())


def _shows_loop(found: TrajectoryGains) -> bool:
    """Return whether vehicles move as the loop does alone, and it damps."""
    return found.explained >= EXPLAINED and dict(found.intervals)["k_d"].is_positive


def _joined(name: str, fits: Sequence[TrajectoryGains]) -> Interval:
    """Return the estimate of the first fit with the interval that holds those of all."""
    each = [dict(one.intervals)[name] for one in fits]
    return Interval(each[0].value, min(one.low for one in each), max(one.high for one in each))


def _unknown(name: str, found: TrajectoryGains) -> Interval:
    return Interval(dict(found.intervals)[name].value, 0.0, HIGH[name])


def _unshown_note(found: TrajectoryGains) -> str:
    return (
        "the model file has no gains: a loop that settles on its reference after an initial error or with an "
        f"offset explains {max(found.explained, 0.0):.0%} of what vehicles deviate from theirs, and shows "
        f"its gains from {EXPLAINED:.0%} on, with damping above 0: record the topics command and reference"
    )
