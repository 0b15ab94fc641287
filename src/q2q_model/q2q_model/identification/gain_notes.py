"""Notes of `identify` on gains from commands."""

from collections.abc import Sequence

import numpy as np

from q2q_model.identification.gains.command_gains import GainFit
from q2q_model.identification.gains.gain_agreement import FlightGain
from q2q_model.identification.push.sensor_check import MOST_OFFSET, mass_remedy
from q2q_model.recordings.flight_recording import Recording
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import GRAVITY, Vehicle

LIMITED = 0.1
"""Share of rows at the limit of a velocity setpoint from which it is reported [-]."""
ROUNDED_TO = 1e-3
"""Resolution of positions from which it is reported [m]."""
ROUNDING_ERROR = 1e-3
"""Largest deviation of a rounded position from a multiple of ROUNDED_TO, over it: single precision [-]."""
MOST_ROUNDED = 0.9
"""Share of rounded heights from which positions are: others lie between, interpolated or repaired [-]."""


def gain_notes(fit: GainFit, recordings: Sequence[Recording], vehicle: Vehicle) -> list[str]:
    """Return what limits the use of gains that the commands of recordings gave."""
    return [
        *_weight_note(fit, vehicle),
        *_limit_note(fit),
        *_sign_note(fit),
        *_filter_note(recordings),
        *_rounding_note(recordings),
    ]


def difference_note(least: FlightGain, most: FlightGain) -> list[str]:
    """Return a note on two flights whose gains differ."""
    of_each = " and ".join(
        f"{one.symbol} {one.gain.value:.3g} [{one.gain.low:.3g}, {one.gain.high:.3g}] in {one.flight}"
        for one in (least, most)
    )
    return [
        (
            f"the flights were flown with different gains: {of_each}: a joint fit describes neither "
            "controller, so the model file has no gains: identify the flights of each controller alone"
        )
    ]


def _limit_note(fit: GainFit) -> list[str]:
    """Return a note if rows with velocity setpoints at their limit were left out of the gains."""
    if fit.limited < LIMITED:
        return []
    return [
        (
            f"{fit.limited:.0%} of the rows with commands are left out of the gains: their velocity setpoint "
            "is at its limit, and their acceleration is its derivative, not what the controller was given"
        )
    ]


def _sign_note(fit: GainFit) -> list[str]:
    """Return a note if the gains do not hold a vehicle at its reference."""
    reason = unstable_reason(fit)
    return [f"the model file has no gains, as {reason}"] if reason else []


def unstable_reason(fit: GainFit) -> str:
    """Return why a loop with these gains leads away from the reference; empty if it does not."""
    if fit.loop.k_p > 0.0 and fit.loop.k_d > 0.0:
        return ""
    return (
        f"K_p {fit.loop.k_p:.3g} and K_d {fit.loop.k_d:.3g} are not both above 0: check that z is up in "
        "positions and references, and that the reference is the controller's"
    )


def carries_other_weight(fit: GainFit) -> bool:
    """Return whether the commanded thrust carries another weight than that of the vehicle assumed."""
    return abs(fit.loop.offset) > MOST_OFFSET


def _weight_note(fit: GainFit, vehicle: Vehicle) -> list[str]:
    """Return a note if the commanded thrust carries another weight than the vehicle's."""
    if not carries_other_weight(fit):
        return []
    carried = vehicle.mass * (1.0 + fit.loop.offset / GRAVITY)
    return [
        (
            f"the commanded thrust carries {1e3 * carried:.1f} g, and {vehicle.name} weighs "
            f"{1e3 * vehicle.mass:.1f} g: the gains are wrong by that ratio: {mass_remedy(carried, vehicle)}"
        )
    ]


def _filter_note(recordings: Sequence[Recording]) -> list[str]:
    """Return a note if velocities are filtered positions, which need not be those that the controller had."""
    count = sum(one.filtered for one in recordings)
    if not count:
        return []
    return [
        (
            f"{count} of {len(recordings)} flights have no states: K_d is fitted to velocities from the "
            "mocap filter. It is too small, beyond its interval, if the controller used other velocities "
            "(4.7 for 5 by noise of 0.3 mm, 3.5 by 1 mm): record the topic state"
        )
    ]


def _rounding_note(recordings: Sequence[Recording]) -> list[str]:
    """Return a note if positions were logged in whole millimetres, which the controller's were not."""
    rounded = [one.flight.name for one in recordings if in_whole_millimetres(one.flight.pos[..., 2])]
    if not rounded:
        return []
    return [
        (
            f"positions are in whole millimetres in {len(rounded)} of {len(recordings)} flights: K_p and K_d "
            "are too small, beyond their intervals, where vehicles keep close to their references (8.9 for "
            "10 and 4.7 for 5 in quiet flight): log positions to 0.1 mm, or fly larger motions"
        )
    ]


def in_whole_millimetres(height: Array) -> bool:
    """Return whether heights [m], (T, n), that vary are multiples of ROUNDED_TO."""
    units = height[np.isfinite(height)] / ROUNDED_TO
    off = np.abs(units - np.round(units))
    varies = bool(units.size) and float(np.ptp(units)) > 1.0
    return varies and float((off < ROUNDING_ERROR).mean()) > MOST_ROUNDED
