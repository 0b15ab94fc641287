"""Metrics of a flight: those of the paper's Table 6, separation and time in the zone.

    z RMSE   = sqrt(1/T int (z - z_ref)^2 dt)          against the plan, of the truth if known
    effort   = int U1^2 dt,   above hover: - (m g)^2 T     control effort; the paper's "energy"
    under, clear = z RMSE under another vehicle, in clear air (q2q_sim.monitors.metrics.exposure)
    worst    = max |z - z_ref| under another vehicle
    separation = min over pairs and time of |r_i - r_j|
    zone time  = time with any pair in the zone I(eps, d)

Integrals are sums over ticks times the tick; a row's thrust counts until the next row. NaN if the flight
lacks the data.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from q2q_model.estimation.mocap_filter_params import MocapFilterParams
from q2q_model.flights.flight import Flight
from q2q_model.flights.masks_over_time import last_row, last_time
from q2q_model.geometry.zone import Cylinder
from q2q_model.signals.stamps import SAME_INSTANT
from q2q_model.signals.values import Array, Mask
from q2q_model.vehicle.constants import Vehicle
from q2q_sim.monitors.metrics.exposure import Exposure, exposure
from q2q_sim.monitors.metrics.proximity import any_in_zone, least_distances

PAPER_ZONE = Cylinder()
"""I(0.1, 1.1)."""


@dataclass(frozen=True, slots=True)
class VehicleMetrics:
    """Metrics of one vehicle; NaN where unknown."""

    z_rmse_m: float
    xy_rmse_m: float
    u1_energy: float
    """Control effort [N^2 s]."""
    u1_energy_above_hover: float
    """Control effort beyond that of hovering [N^2 s]."""
    u1_max: float
    """[N]"""
    under_rms_m: float
    clear_rms_m: float
    worst_m: float


@dataclass(frozen=True, slots=True)
class FlightMetrics:
    """Metrics of a flight; NaN where unknown."""

    vehicles: Mapping[str, VehicleMetrics]
    min_separation_m: float
    zone_time_s: float


def measure(flight: Flight, vehicle: Vehicle, zone: Cylinder = PAPER_ZONE) -> FlightMetrics:
    """Return the metrics of a flight of `vehicle`s; the zone defaults to the paper's."""
    pos = best_position(flight)
    dt, lasting = tick_period(flight), row_durations(flight)
    separation, zone_time = _closeness(pos, dt, zone)
    weight, when = vehicle.hover_thrust, exposure(pos, flight.t)
    rows = {
        name: _vehicle(
            Exposure(when.under[:, i], when.clear[:, i]),
            pos[:, i] - flight.ref_pos[:, i],
            flight.thrust[:, i],
            lasting,
            weight,
        )
        for i, name in enumerate(flight.names)
    }
    return FlightMetrics(vehicles=rows, min_separation_m=separation, zone_time_s=zone_time)


def best_position(flight: Flight) -> Array:
    """Return the true positions if known, else the filtered ones [m], (T, n, 3); NaN where neither is.

    A filter puts a vehicle that it has never seen at the origin, and holds the last position of one that it
    has lost. In a flight with motion capture, filtered positions count for coast_s after a sample.
    """
    seen: Mask = np.asarray(np.isfinite(flight.mocap_pos).all(axis=2))  # (T, n)
    unseen: Array = flight.t[:, None] - last_time(seen, flight.t)
    known = (unseen <= MocapFilterParams().coast_s + SAME_INSTANT) | ~seen.any()
    filtered = np.where(known[..., None], flight.pos, np.nan)
    return np.where(np.isfinite(flight.true_pos), flight.true_pos, filtered)


def tick_period(flight: Flight) -> float:
    """Return the time between ticks [s]; NaN for fewer than two."""
    return float(np.median(np.diff(flight.t))) if len(flight.t) > 1 else float("nan")


def row_durations(flight: Flight) -> Array:
    """Return the time from each row to the next [s], the tick at the last; lost ticks have no row, (T,)."""
    return np.append(np.diff(flight.t), tick_period(flight))


def _vehicle(when: Exposure, error: Array, thrust: Array, lasting: Array, weight: float) -> VehicleMetrics:
    """Return the metrics of one vehicle from exposure, error (T, 3), thrust and durations of rows (T,)."""
    given = held_thrust(thrust)
    known, lasting = len(given) > 0, lasting[len(lasting) - len(given) :]
    effort = float(np.sum(given**2 * lasting)) if known else float("nan")
    return VehicleMetrics(
        z_rmse_m=rms(_recorded(error[:, 2])),
        xy_rmse_m=rms(_recorded(np.hypot(error[:, 0], error[:, 1]))),
        u1_energy=effort,
        u1_energy_above_hover=effort - weight**2 * float(np.sum(lasting)),
        u1_max=float(given.max()) if known else float("nan"),
        under_rms_m=rms(_recorded(error[when.under, 2])),
        clear_rms_m=rms(_recorded(error[when.clear, 2])),
        worst_m=largest(_recorded(error[when.under, 2])),
    )


def held_thrust(thrust: Array) -> Array:
    """Return commanded thrust from the first command; a tick without one holds the last, (<= T,)."""
    last = last_row(np.isfinite(thrust))
    return np.asarray(thrust[last[last >= 0]])


def rms(error: Array) -> float:
    """Return the root mean square of errors (m,); NaN of nothing, and not finite if an error is not."""
    return float(np.sqrt(np.mean(error**2))) if error.size else float("nan")


def largest(error: Array) -> float:
    """Return the largest size of errors (m,); NaN of nothing, and not finite if an error is not."""
    return float(np.abs(error).max()) if error.size else float("nan")


def _recorded(error: Array) -> Array:
    """Return the errors that are recorded: all but NaN."""
    return np.asarray(error[~np.isnan(error)])


def _closeness(pos: Array, dt: float, zone: Cylinder) -> tuple[float, float]:
    """Return the smallest distance [m] and the time with any pair in the zone [s]."""
    ticks, n, _ = pos.shape
    if n < 2 or ticks == 0:
        return float("nan"), float("nan")
    least = float(least_distances(pos).min())
    if not np.isfinite(least):
        return float("nan"), float("nan")
    return least, float(any_in_zone(pos, zone).sum() * dt)
