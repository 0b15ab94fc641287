"""Gains of the altitude loop where no commands were recorded, and whether poses show them.

Any motion is fitted best by some loop. One that does not damp fits noise and gusts, and one of vehicles that
stay at their references fits anything. Gains are known if a loop explains the deviation of vehicles from
their references, sum dev^2 up to a tenth, in the rows where its response is above what it leaves
(trajectory_gains), and K_p and K_d are above 0; else their intervals are all that was searched.

It is not known, either, whether thrust lags and whether the controller integrates, as an integral that flew
is seldom significant: intervals hold those of the fits without lag and with the most that it may be, without
and with an integral. An offset is fitted if it makes the fit significantly better. A fit with an integral is
left out if that with an offset is significantly better.
"""

from collections.abc import Sequence

from q2q_model.identification.gains.altitude_record import AltitudeRecord
from q2q_model.identification.gains.command_gains import GainFit
from q2q_model.identification.gains.trajectory_gains import (
    ABOVE,
    HIGH,
    INTEGRAL,
    OFFSET,
    TrajectoryGains,
    gains_from_trajectories,
    is_better,
)
from q2q_model.identification.statistics.intervals import Interval
from q2q_model.vehicle.constants import Vehicle

EXPLAINED = 0.9
"""Share of the mean square deviation that a loop must explain for its gains to be known [-]. In
simulated flights with gusts, noise, downwash, integrals and lag, intervals above it hold the flown gains."""
DELAY = 0.02
"""Most that motion capture, radio and sampling delay a command in addition to the thrust lag [s]."""
SHOWN = {"k_p": "K_p", "k_d": "K_d"}
"""Gains that must be above 0, and what notes call them."""
REMEDY = "record the topics command and reference"


def gains_from_poses(records: Sequence[AltitudeRecord], vehicle: Vehicle) -> tuple[GainFit, list[str]]:
    """Return the loop that predicts altitudes best, with intervals of its gains, and notes."""
    found, options = _best(records)
    fits, unshown = [found], _unshown(found)
    if not unshown:
        most_lag = vehicle.thrust_lag + DELAY
        fits.append(gains_from_trajectories(records, options, most_lag))
        integral = [gains_from_trajectories(records, (INTEGRAL,), lag) for lag in (0.0, most_lag)]
        fits += [one for one in integral if not (options and is_better(found, one))]
        unshown = next(filter(None, map(_unshown, fits)), "")
    k_p, k_d = (_unknown(name, found) if unshown else _joined(name, fits) for name in ("k_p", "k_d"))
    fit = GainFit(
        loop=found.loop,
        k_p=k_p,
        k_d=k_d,
        needs_offset=OFFSET in options,
        needs_integral=False,
        rms=found.rms,
        from_commands=False,
    )
    return fit, [f"the model file has no gains: {unshown}: {REMEDY}"] if unshown else []


def _best(records: Sequence[AltitudeRecord]) -> tuple[TrajectoryGains, tuple[str, ...]]:
    """Return the fit with an offset if that is significantly better, and its options."""
    found, shifted = gains_from_trajectories(records), gains_from_trajectories(records, (OFFSET,))
    return (shifted, (OFFSET,)) if is_better(shifted, found) else (found, ())


def _unshown(found: TrajectoryGains) -> str:
    """Return why vehicles do not show the gains of a loop; empty if they do."""
    lag = f"a thrust lag of {found.loop.lag:.2g} s" if found.loop.lag > 0.0 else "no lag"
    loop = f"a loop with {lag}" + (" and an integral" if found.loop.k_i > 0.0 else "")
    settles = f"{loop} that settles from an initial error or with an offset"
    if found.explained == 0.0:
        return (
            f"{settles} moves vehicles nowhere {ABOVE:g} times as far from their references as the "
            f"{1e3 * found.rms:.2g} mm that it leaves unexplained"
        )
    if found.explained < EXPLAINED:
        return (
            f"{settles} explains {found.explained:.1%} of the deviation of vehicles from their references, "
            f"in mean square where it moves them; the minimum is {EXPLAINED:.0%}"
        )
    for name, one in found.intervals:
        if name in SHOWN and not one.is_positive:
            return f"{SHOWN[name]} of {loop} may be 0: {one.value:.3g} [{one.low:.3g}, {one.high:.3g}]"
    return ""


def _joined(name: str, fits: Sequence[TrajectoryGains]) -> Interval:
    """Return the estimate of the first fit with the interval that holds those of all."""
    each = [dict(one.intervals)[name] for one in fits]
    return Interval(each[0].value, min(one.low for one in each), max(one.high for one in each))


def _unknown(name: str, found: TrajectoryGains) -> Interval:
    return Interval(dict(found.intervals)[name].value, 0.0, HIGH[name])
