"""Check of the push in a log against that of accelerometer and command, where a flight has both.

Over the exposed rows of all flights, each push less its median over free rows,

    slope = sum (push of log) (push of sensors) / sum (push of sensors)^2

is 0.4 to 1 in recorded flights, as gusts and the accelerometer's noise are only in the second. It shows a
force of the wrong sign or in another unit than newtons.
"""

from collections.abc import Sequence

import numpy as np

from q2q_model.identification.push.push_samples import FEWEST_FREE, scored_rows
from q2q_model.identification.push.recorded_push import push_log, push_of_sensors, push_record
from q2q_model.recordings.flight_recording import Recording
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import Vehicle

SLOPES = (0.25, 2.0)
"""Bounds of the slope [-]: the smallest of recorded flights is 0.44."""


def log_notes(recordings: Sequence[Recording], vehicle: Vehicle) -> list[str]:
    """Return a note if logged forces contradict accelerometer and command under other vehicles."""
    parts = [part for one in recordings for part in _exposed_pushes(one, vehicle)]
    logged, felt = np.concatenate([np.zeros((2, 0)), *parts], axis=1)
    if logged.size < FEWEST_FREE:
        return []
    slope = float(logged @ felt) / float(felt @ felt)
    if SLOPES[0] <= slope <= SLOPES[1]:
        return []
    return [
        (
            f"faz_est under other vehicles is {slope:.2f} times what accelerometer and command show, "
            f"expected {SLOPES[0]:g} to {SLOPES[1]:g}: check that it is in newtons and positive upwards"
        )
    ]


def _exposed_pushes(one: Recording, vehicle: Vehicle) -> list[Array]:
    """Return the push of the log and that of sensors on exposed rows, (2, k) for every vehicle."""
    sensed = push_of_sensors(one.flight, vehicle, vehicle.thrust_lag)
    logged = push_record(one, vehicle, vehicle.thrust_lag)
    log = push_log(one)
    if log is None or sensed is None or logged is None:
        return []
    found = []
    for i, rows in enumerate(scored_rows(logged)):
        both = sensed.measured[:, i] & np.isfinite(log.column("faz_est")[:, i])
        free, exposed = rows.free & both, rows.exposed & both
        if free.sum() >= FEWEST_FREE:
            pushes = np.stack([logged.push[:, i], sensed.push[:, i]])
            found.append(pushes[:, exposed] - np.median(pushes[:, free], axis=1, keepdims=True))
    return found
