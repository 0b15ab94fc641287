"""Tables of recorded flights: tracking, limits of commands and separation, motion capture, nodes."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, astuple, dataclass

import numpy as np

from q2q_model.documents.json_file import Json
from q2q_model.flights.flight import Flight
from q2q_model.signals.values import Array, CommandStatus, Mask
from q2q_model.vehicle.constants import Vehicle
from q2q_sim.flight_bag.recorded_diagnostics import NodeLife
from q2q_sim.monitors.flight_verdict import FlightVerdict
from q2q_sim.monitors.metrics.flight_metrics import FlightMetrics
from q2q_sim.monitors.mocap_quality import MocapQuality
from q2q_sim.report.html_page import Grid, Heading, Part
from q2q_sim.report.significant_digits import significant_digits
from q2q_sim.report.vehicle_rows import vehicle_rows

TRACKING = {
    "z_rmse_m": "z RMSE [m]",
    "xy_rmse_m": "xy RMSE [m]",
    "u1_energy": "control effort ∫ U1² dt [N²s]",
    "u1_energy_above_hover": "above hover [N²s]",
    "u1_max": "max U1 [N]",
    "under_rms_m": "z RMSE under another [m]",
    "clear_rms_m": "in clear air [m]",
    "worst_m": "worst under another [m]",
}
"""Columns of the first table by their field of VehicleMetrics."""
HEAD = ("flight", "vehicle", *TRACKING.values())
HEAD_LIMITS = (
    "flight",
    "vehicle",
    "saturated [%]",
    "fallback [%]",
    "separation [m]",
    "in the zone [s]",
)
"""The fields of CommandLimits after flight and vehicle."""
HEAD_NODES = ("flight", "node", "seconds", "in trouble", "worst", "last values")
HEAD_MOCAP = ("flight", "vehicle", "rate [Hz]", "seen [%]", "longest gap [s]", "rejected")


@dataclass(frozen=True, slots=True)
class CommandLimits:
    """How often the commands of a vehicle were limited, and how close the vehicles of its flight came."""

    saturated_percent: float
    fallback_percent: float
    min_separation_m: float
    zone_time_s: float


@dataclass(frozen=True, slots=True)
class Reported:
    """Flight with its metrics."""

    flight: Flight
    metrics: FlightMetrics
    quality: dict[str, MocapQuality]
    lives: tuple[NodeLife, ...]
    """Health of its nodes, if `/diagnostics` was recorded."""
    verdict: FlightVerdict
    vehicle: Vehicle
    note: str
    """Assumed vehicle, if the bag does not name it."""
    air: str
    """Air of the simulator, if known."""


def tracking_table(flights: Sequence[Reported]) -> Grid:
    """Return the errors and efforts of each vehicle."""
    return Grid(HEAD, [row for one in flights for row in _tracking(one)])


def limits_table(flights: Sequence[Reported]) -> Grid:
    """Return the limits of each vehicle."""
    return Grid(HEAD_LIMITS, [row for one in flights for row in limit_rows(one)])


def mocap_table(flights: Sequence[Reported]) -> Grid:
    """Return how well motion capture saw each vehicle."""
    return Grid(HEAD_MOCAP, [row for one in flights for row in _mocap(one)])


def nodes_table(flights: Sequence[Reported]) -> list[Part]:
    """Return heading and table of the nodes; none if no bag has `/diagnostics`."""
    rows = [
        (one.flight.name, life.node, str(life.seconds), str(life.warned), life.worst.name, life.values)
        for one in flights
        for life in one.lives
    ]
    return [Heading("Nodes"), Grid(HEAD_NODES, rows)] if rows else []


def as_json(flights: Sequence[Reported]) -> Json:
    """Return the numbers of the tables; NaN where unknown."""
    return {one.flight.name: _vehicles_json(one) for one in flights}


def _vehicles_json(one: Reported) -> Json:
    limits = _limits(one)
    return {
        name: {**asdict(vehicle), **asdict(limits[name]), "mocap": asdict(one.quality[name])}
        for name, vehicle in one.metrics.vehicles.items()
    }


def _tracking(one: Reported) -> list[tuple[str, ...]]:
    numbers = {name: asdict(vehicle) for name, vehicle in one.metrics.vehicles.items()}
    return _lines(one, {name: [found[field] for field in TRACKING] for name, found in numbers.items()})


def limit_rows(one: Reported) -> list[tuple[str, ...]]:
    """Return the rows of the second table: shares of limited commands, and how close the vehicles came."""
    return _lines(one, {name: list(astuple(limits)) for name, limits in _limits(one).items()})


def _limits(one: Reported) -> dict[str, CommandLimits]:
    """Return the limits of each vehicle."""
    return {
        name: CommandLimits(
            saturated_percent=_percent(status, status == CommandStatus.SATURATED),
            fallback_percent=_percent(status, status >= CommandStatus.HOLD),
            min_separation_m=one.metrics.min_separation_m,
            zone_time_s=one.metrics.zone_time_s,
        )
        for name, status in zip(one.flight.names, one.flight.command_status.T, strict=True)
    }


def _mocap(one: Reported) -> list[tuple[str, ...]]:
    return _lines(
        one,
        {
            name: [found.rate_hz, 100.0 * found.seen_share, found.longest_gap_s, found.rejected]
            for name, found in one.quality.items()
        },
    )


def _lines(one: Reported, numbers: Mapping[str, Sequence[float]]) -> list[tuple[str, ...]]:
    """Return the rows of a table about one flight."""
    return [(one.flight.name, name, *map(significant_digits, row)) for name, row in vehicle_rows(numbers)]


def _percent(status: Array, condition: Mask) -> float:
    """Return the share of ticks with a condition; NaN without any command."""
    return 100.0 * float(np.mean(condition)) if np.isfinite(status).any() else np.nan
