"""Notes on measured pushes that an identification does not use, and on what it then does not know.

Without the push on any vehicle under another, downwash is inferred from altitudes. There, only settled clear
air (gains.impulse_response) tells a constant of the vehicle (battery, mass) from downwash; without it the
strength of the downwash may be anything.
"""

from collections.abc import Sequence
from dataclasses import replace

from q2q_model.identification.gains.impulse_response import LEAST, knows_constant
from q2q_model.identification.jet.jet_form import FREE_PARAMETERS
from q2q_model.identification.push.push_samples import APART, FEWEST_FREE, FLOOR, PushRecord, scored_rows
from q2q_model.identification.selection.identification_data import (
    IdentificationData,
    every_record,
    has_exposure,
    measures_downwash,
    under_others,
)
from q2q_model.identification.statistics.intervals import Interval
from q2q_model.vehicle.altitude_loop import AltitudeLoop

Spread = tuple[tuple[str, Interval], ...]


def unused_push_notes(
    pushes: Sequence[PushRecord | None], data: Sequence[IdentificationData], loop: AltitudeLoop | None
) -> list[str]:
    """Return a note on flights whose push on vehicles under others is not used, one for each reason.

    Args:
        pushes: measured push of each flight; None where none was measured.
        data: of the same flights.
        loop: of commands, which predicts altitudes; None if it is of trajectories, with their constant.
    """
    inferred = not measures_downwash(data)
    flights: dict[str, list[str]] = {}
    for push, one in zip(pushes, data, strict=True):
        rare = _without_clear_air(push)
        if any(map(has_exposure, one.records)) and (reason := _unused_reason(push, rare, one)):
            text = (
                f"downwash is inferred from altitudes: {reason}{_constant_note([one], loop)}"
                if inferred
                else f"the push{' on ' * bool(rare)}{', '.join(rare)} is not used: {reason}"
            )
            flights.setdefault(text, []).append(one.name)
    return [f"{', '.join(names)}: {text}" for text, names in flights.items()]


def with_unknown_strength(
    spread: Spread, data: Sequence[IdentificationData], loop: AltitudeLoop | None
) -> Spread:
    """Return intervals of a model's parameters, that of a strength of which nothing is known unbounded.

    It is so if downwash is inferred from altitudes of vehicles whose constant is unknown.
    """
    if measures_downwash(data) or not unknown_constants(data, loop):
        return spread
    bound = FREE_PARAMETERS["strength"]
    return tuple(
        (name, replace(one, low=bound.low, high=bound.high) if name == "strength" else one)
        for name, one in spread
    )


def unknown_constants(data: Sequence[IdentificationData], loop: AltitudeLoop | None) -> list[str]:
    """Return the names of vehicles under others whose constant clear air does not show."""
    if loop is None:
        return []
    found: dict[str, None] = {}
    for record in every_record(data):
        rows = under_others(record) & ~knows_constant(record, loop)
        found |= dict.fromkeys(name for name, row in zip(record.names, rows, strict=True) if row)
    return list(found)


def _constant_note(data: Sequence[IdentificationData], loop: AltitudeLoop | None) -> str:
    if not (unknown := unknown_constants(data, loop)):
        return ""
    return (
        f"; the constant of {', '.join(unknown)} is unknown without {LEAST:g} s of settled clear air, and an "
        "offset counts as downwash, whose strength is unknown: do not use the model for compensation"
    )


def _without_clear_air(push: PushRecord | None) -> list[str]:
    """Return the names of vehicles under others with too few rows in clear air: their push is not used."""
    rows = [] if push is None else zip(push.names, scored_rows(push), strict=True)
    return [name for name, own in rows if own.exposed.any() and own.free.sum() < FEWEST_FREE]


def _unused_reason(push: PushRecord | None, rare: Sequence[str], one: IdentificationData) -> str:
    """Return why the push on vehicles of a flight is not used; empty if it is."""
    if push is None:
        return "no push was measured, record imu and command, or a log with faz_est, gap and pwm1-4"
    if rare:
        return (
            f"{', '.join(rare)} {'has' if len(rare) == 1 else 'have'} fewer than {FEWEST_FREE} measured rows "
            f"in clear air; they are needed for the constant of a push: above {FLOOR} m, no vehicle above or "
            f"below within {APART} m horizontally"
        )
    if any(own.exposed.any() for own in one.pushes):
        return ""
    return "nothing was measured of the vehicle below while another was above it"
