"""Gains of recordings, from commands or else from trajectories, and the loop that predicts altitudes."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from q2q_model.identification.gain_notes import carries_other_weight, difference_note, gain_notes
from q2q_model.identification.gains.altitude_record import AltitudeRecord
from q2q_model.identification.gains.command_gains import GainFit, gains_from_commands
from q2q_model.identification.gains.gain_agreement import differing_gains
from q2q_model.identification.gains.gains_from_poses import gains_from_poses
from q2q_model.identification.gains.impulse_response import with_added_acc
from q2q_model.recordings.flight_recording import Recording
from q2q_model.vehicle.altitude_loop import AltitudeLoop
from q2q_model.vehicle.constants import Vehicle


def recorded_gains(
    records: Sequence[AltitudeRecord], recordings: Sequence[Recording], vehicle: Vehicle
) -> tuple[GainFit, list[str]]:
    """Return the gains of all records, and notes; from trajectories if there are too few commands.

    With the mass of another vehicle, gains of one controller differ between flights: they are not compared.

    Raises:
        ValueError: trajectories give no gains either.
    """
    try:
        fit = gains_from_commands(records)
    except ValueError as missing:
        fit, unshown = gains_from_poses(records, vehicle)
        notes = [f"gains are from trajectories, downwash and lag included: {missing}"]
        return fit, [*notes, *unshown, *_feed_forward_note(records)]
    differing = None if carries_other_weight(fit) else differing_gains(records)
    notes = difference_note(*differing) if differing else []
    return replace(fit, alike=not differing), [*notes, *gain_notes(fit, recordings, vehicle)]


def _feed_forward_note(records: Sequence[AltitudeRecord]) -> list[str]:
    """Return a note if a controller may have compensated downwash, and no commands show how much of it."""
    if not any((np.nan_to_num(record.feed_forward) != 0.0).any() for record in records):
        return []
    return [
        (
            "the topic interference is recorded, but no commands: if the controller compensated it, the "
            "model describes only the remainder; record the topic command"
        )
    ]


def predicting_loop(
    gains: GainFit, flown: Sequence[tuple[AltitudeRecord, ...]], vehicle: Vehicle
) -> tuple[AltitudeLoop, Sequence[tuple[AltitudeRecord, ...]]]:
    """Return the loop that predicts altitudes, and the records with what commands show besides."""
    if not gains.from_commands:
        return gains.loop, flown
    loop = replace(gains.loop, lag=vehicle.thrust_lag, offset=0.0)
    return loop, [
        tuple(with_added_acc(one, loop, gains.compensated[one.name], gains.of_rates) for one in pieces)
        for pieces in flown
    ]
