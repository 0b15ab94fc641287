"""Note on logs whose thrust does not show the mass by which their force is divided."""

from collections.abc import Sequence

import numpy as np

from q2q_model.counted import counted
from q2q_model.identification.push.recorded_push import HEAVIEST, LIGHTEST, can_weigh, push_log, shown_mass
from q2q_model.recordings.flight_recording import Recording
from q2q_model.vehicle.constants import Vehicle

RATIO = "(faz_est + thrust_est) / (a_z + g)"


def log_mass_notes(recordings: Sequence[Recording], vehicle: Vehicle) -> list[str]:
    """Return notes on flights whose thrust_est shows no mass, or one that `vehicle` cannot have."""
    logs = [(push_log(one), one.flight) for one in recordings]
    shown = np.array([shown_mass(log, flight) for log, flight in logs if log and "thrust_est" in log.columns])
    unknown = int(np.isnan(shown).sum())
    wrong = [mass for mass in shown[~np.isnan(shown)].tolist() if not can_weigh(vehicle, mass)]
    notes = []
    if unknown:
        notes.append(
            f"{RATIO} of {counted(unknown, 'flight')} is unknown: {_assumed(vehicle)}; "
            "record accelerometer and attitude"
        )
    if wrong:
        notes.append(
            f"{RATIO} of {counted(len(wrong), 'flight')} is {float(np.median(wrong)):.3g} kg, expected "
            f"{LIGHTEST:g} to {HEAVIEST:g} times the mass of {vehicle.name}: {_assumed(vehicle)}; check that "
            "both are in newtons and az is in m/s^2 without gravity"
        )
    return notes


def _assumed(vehicle: Vehicle) -> str:
    return f"faz_est is divided by the {1e3 * vehicle.mass:g} g of {vehicle.name}"
