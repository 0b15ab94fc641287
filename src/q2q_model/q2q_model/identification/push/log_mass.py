"""Mass by which the force of each vehicle in a log was computed.

    m = median of (faz_est + thrust_est) / (a_z + g)

of each vehicle by itself, as vehicles of one flight may differ: of two of 32 and 48 g, a common median gives
the lighter one 20 % too little downwash. Medians of vehicles of the same mass differ by at most 0.2 g in real
flights, whose logs were made with 32 g throughout.
"""

import numpy as np

from q2q_model.flights.flight import Flight
from q2q_model.flights.flight_log import FlightLog
from q2q_model.geometry.rotations import rotate
from q2q_model.signals.values import Array, Mask
from q2q_model.vehicle.constants import NEURAL_SWARM_MASS, Vehicle

LOG_MASS = NEURAL_SWARM_MASS
"""Mass m in the logs of the flights of Neural-Swarm2 [kg]."""
LOG_MASS_WITHIN = 0.0005
"""What the mass that a vehicle shows in such a log may differ from LOG_MASS by [kg]: 0.00033 at most."""
LIGHTEST, HEAVIEST = 0.5, 2.0
"""Bounds of the median thrust in the air, and of the masses of a log, over the vehicle's [-]; 0.92 to 1.3 in
recorded flights of 34 g."""


def log_masses(log: FlightLog, flight: Flight, vehicle: Vehicle) -> Array:
    """Return the mass m by which the force of each vehicle in a log was computed [kg], (n,).

    It is the one that the vehicle's own rows show, or that of `vehicle` if they show none, or one that it
    cannot have.
    """
    shown = shown_masses(log, flight)
    own = np.where(np.abs(shown - LOG_MASS) < LOG_MASS_WITHIN, LOG_MASS, shown)
    return np.where(can_weigh(vehicle, shown), own, vehicle.mass)


def shown_masses(log: FlightLog, flight: Flight) -> Array:
    """Return the median (faz_est + thrust_est) / (a_z + g) of each vehicle [kg], (n,); NaN if unknown."""
    if "thrust_est" not in log.columns:
        return np.full(len(log.names), np.nan)
    felt = rotate(flight.quat, flight.specific_force_body)[..., 2]
    ratio = (log.column("faz_est") + log.column("thrust_est")) / felt
    return np.array(
        [np.median(own[np.isfinite(own)]) if np.isfinite(own).any() else np.nan for own in ratio.T]
    )


def can_weigh(vehicle: Vehicle, masses: Array) -> Mask:
    """Return whether a vehicle may have masses [kg], (n,); False for NaN."""
    share = masses / vehicle.mass
    return np.asarray((share >= LIGHTEST) & (share <= HEAVIEST))
