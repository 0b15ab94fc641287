"""Positions logged in whole millimetres are reported beside the gains, which they make too small."""

from dataclasses import replace

import numpy as np
import pytest
from made_flights import CALM, made_flight

from q2q_model.identification.gain_notes import gain_notes, in_whole_millimetres
from q2q_model.identification.gains.altitude_from_flight import altitude_record
from q2q_model.identification.gains.command_gains import gains_from_commands
from q2q_model.recordings.flight_recording import Recording
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import CRAZYFLIE_2_0

HEIGHT = 1.0 + 0.02 * np.random.default_rng(1).standard_normal((500, 2))
GAP = np.where(np.arange(500)[:, None] < 20, np.nan, 1.0)


@pytest.mark.parametrize(
    ("height", "whole"),
    [
        (np.round(HEIGHT, 3), True),
        (np.round(HEIGHT, 2), True),
        (np.round(HEIGHT, 3).astype(np.float32).astype(np.float64), True),
        (np.round(HEIGHT, 3) * GAP, True),
        (HEIGHT, False),
        (np.round(HEIGHT, 4), False),
        (np.zeros((500, 2)), False),
        (np.full((500, 2), np.nan), False),
    ],
)
def test_heights_in_whole_millimetres_are_found(height: Array, *, whole: bool) -> None:
    assert in_whole_millimetres(height) is whole


def test_a_flight_in_whole_millimetres_is_reported() -> None:
    made = made_flight(CALM)
    fit = gains_from_commands([altitude_record(made, CRAZYFLIE_2_0)])
    rounded = replace(made, pos=np.round(made.pos, 3))
    notes = gain_notes(fit, [Recording(rounded), Recording(made)], CRAZYFLIE_2_0)
    assert any(note.startswith("positions are in whole millimetres in 1 of 2 flights") for note in notes)
    assert not any("millimetres" in note for note in gain_notes(fit, [Recording(made)], CRAZYFLIE_2_0))
