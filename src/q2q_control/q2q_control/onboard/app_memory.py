"""Memory of the firmware app: past motion that it keeps of every vehicle, and what is left on a vehicle.

samples = ceil(span rate) + 2,   span = longest delay of the jet + span of a source's acceleration
bytes = (1 + neighbours) (40 samples + 16) + 44        sizeof(struct q2q_app)
"""

import numpy as np

from q2q_model.downwash.jet import Jet
from q2q_model.downwash.source_strength import HALF_SPAN_S, PAIRS_ALONE, source_terms

FREE_BYTES = 29_044
"""RAM that the default firmware of a Crazyflie 2.x leaves of the 128 kB of its STM32F405 that hold an app
(bitcraze/crazyflie-firmware, pull request 1700, August 2026)."""
GLUE_BYTES = 2_000
"""Queues, packets and stack of app_main.c: 0.5 kB, and CONFIG_APP_STACKSIZE words of 4 bytes."""
LARGEST_BYTES = FREE_BYTES - GLUE_BYTES
"""Largest struct q2q_app."""


class AppMemoryError(ValueError):
    """Model whose past does not fit into a vehicle."""


def app_samples(jet: Jet, broadcast_hz: float, neighbours: int) -> int:
    """Return the samples that cover the longest delay, the span of a source's acceleration, and one more.

    Raises:
        AppMemoryError: they do not fit into a vehicle's memory.
    """
    span = jet.max_delay + (HALF_SPAN_S if source_terms(jet) != PAIRS_ALONE else 0.0)
    samples = float(np.ceil(span * broadcast_hz)) + 2.0
    needed = app_bytes(samples, neighbours)
    if needed > LARGEST_BYTES:
        raise AppMemoryError(
            f"the app would take {1e-3 * needed:.0f} kB of RAM; the firmware leaves "
            f"{1e-3 * LARGEST_BYTES:.0f} kB. It keeps the past of {neighbours} neighbours for the longest "
            f"delay of the model, {jet.max_delay:.3g} s: make its range of {jet.range:g} m smaller, or its "
            f"travel_speed of {jet.travel_speed:g} m/s larger"
        )
    return int(samples)


def app_bytes(samples: float, neighbours: int) -> float:
    """Return the size of struct q2q_app on a vehicle [bytes]."""
    return (1 + neighbours) * (40 * samples + 16) + 44
