"""Run of a replay page: what is drawn of one flight, from a bag or from a flight without ROS."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from math import inf

import numpy as np

from q2q_model.flights.flight import Flight
from q2q_model.geometry.zone import Cylinder
from q2q_model.signals.values import Array, Mask, Names
from q2q_model.vehicle.constants import Vehicle
from q2q_sim.air.lookup.travel_speed import travel_speed
from q2q_sim.air.wake_laws import MEASURED_SPEED
from q2q_sim.monitors.flight_judgement import verdict_of
from q2q_sim.monitors.flight_verdict import FlightVerdict
from q2q_sim.monitors.metrics.flight_metrics import best_position
from q2q_sim.monitors.metrics.proximity import under_another
from q2q_sim.monitors.mocap_quality import rejected_samples
from q2q_sim.monitors.policies import Circumstances
from q2q_sim.replay_page.height_loss import LOSS_SHOWN, height_loss, height_loss_text

MOST_LOSSES = 4
"""Vehicles whose largest height loss is marked."""
DOWNWASH_RADIUS = 0.4
"""Distance beside a vehicle above from which on the true push of the air is no downwash [m]: that of the wake
laws is below 0.02 m/s^2 there, at every height difference."""


@dataclass(frozen=True, slots=True)
class ReplayEvent:
    """Moment that is marked on the time bar."""

    t: float
    """[s]"""
    words: str


@dataclass(frozen=True, slots=True)
class ReplayRun:
    """Run of a replay: T ticks, n vehicles; NaN where nothing was recorded."""

    name: str
    names: Names
    t: Array
    """Stamps [s], rising, (T,)."""
    pos: Array
    """Position [m], true where known, else filtered, (T, n, 3)."""
    quat: Array
    """Orientation x y z w, body to world, (T, n, 4)."""
    ref_pos: Array
    """Planned position, else the controller's setpoint [m], (T, n, 3)."""
    mocap_pos: Array
    """Motion-capture position [m], (T, n, 3)."""
    rejected: Mask
    """Motion-capture samples that the filter did not follow, (T, n)."""
    downwash: Array
    """Acceleration by the downwash [m/s^2], true where known, else predicted, (T, n, 3).

    The true one is the whole push of the air on a vehicle under another, and 0 elsewhere.
    """
    thrust: Array
    """Commanded thrust over the weight [-], (T, n)."""
    arm: float
    """Centre to motor [m]."""
    zone: Cylinder = field(default_factory=Cylinder)
    """Zone I(eps, d)."""
    wake_speed: float = MEASURED_SPEED
    """Speed at which the downwash travels [m/s]; infinite where it acts at once, straight below."""
    verdict: str = ""
    """What happened, in one line."""
    events: tuple[ReplayEvent, ...] = ()
    note: str = ""
    """How a quantity was found, where it was not recorded itself."""
    since: float = 0.0
    """Time of the first tick since the start of the flight, of which this may be a part [s]."""

    @property
    def missing(self) -> tuple[str, ...]:
        """Return the quantities that were not recorded."""
        quantities = {
            "attitude": self.quat,
            "reference": self.ref_pos,
            "motion capture": self.mocap_pos,
            "downwash": self.downwash,
            "thrust": self.thrust,
        }
        return tuple(words for words, values in quantities.items() if not np.isfinite(values).any())


def replay_run(
    flight: Flight,
    vehicle: Vehicle,
    name: str = "",
    verdict: FlightVerdict | None = None,
    whole: Flight | None = None,
) -> ReplayRun:
    """Return the run of a flight of `vehicle`s.

    Args:
        flight: what was recorded.
        vehicle: what flew.
        name: name of the run; empty is the flight's own.
        verdict: verdict on the flight; None judges it here.
        whole: the whole flight, if `flight` is a part of it.

    Raises:
        ValueError: the flight has no position of any vehicle.
    """
    pos = _first_known(best_position(flight), flight.mocap_pos)
    if not np.isfinite(pos).any():
        raise ValueError(f"flight {flight.name} has no positions: record mocap, state or truth")
    if verdict is None:
        verdict = verdict_of(flight, Circumstances(vehicle=vehicle), whole=whole)
    since = float(flight.t[0] - (whole or flight).t[0])
    loss = height_loss_text(flight, pos, _reference(flight), since)
    return ReplayRun(
        name=name or flight.name,
        names=flight.names,
        t=flight.t,
        pos=pos,
        quat=_first_known(flight.quat, flight.mocap_quat),
        ref_pos=_reference(flight),
        mocap_pos=flight.mocap_pos,
        rejected=rejected_samples(flight),
        downwash=_first_known(_true_downwash(flight, pos), flight.eta),
        thrust=flight.thrust / vehicle.hover_thrust,
        arm=vehicle.arm,
        verdict=f"{loss}; {verdict}",
        events=tuple(_events(flight, pos, verdict)),
        since=since,
    )


def in_air(run: ReplayRun, air: str) -> ReplayRun:
    """Return a run whose air travels as that of a name, or as in a bag's metadata."""
    return replace(run, wake_speed=travel_speed(air))


def _true_downwash(flight: Flight, pos: Array) -> Array:
    """Return the true push of the air on vehicles under another [m/s^2], (T, n, 3); 0 elsewhere: gusts."""
    under = under_another(pos, DOWNWASH_RADIUS, inf)
    return np.where(under[..., None], flight.true_eta, 0.0 * flight.true_eta)


def _first_known(values: Array, others: Array) -> Array:
    return np.where(np.isfinite(values), values, others)


def _reference(flight: Flight) -> Array:
    """Return the planned positions; where there was none, the setpoints of the controller."""
    return _first_known(flight.ref_pos, flight.safe_pos)


def _events(flight: Flight, pos: Array, verdict: FlightVerdict) -> Iterator[ReplayEvent]:
    """Yield the largest height losses of vehicles under another, and the verdict's findings."""
    loss = np.nan_to_num(height_loss(flight, pos, _reference(flight)))
    deepest = np.argmax(loss, axis=0)
    depths = loss[deepest, np.arange(len(flight.names))]
    for row in np.argsort(-depths)[:MOST_LOSSES]:
        if depths[row] >= LOSS_SHOWN:
            words = f"{flight.names[row]} {100.0 * depths[row]:.0f} cm low"
            yield ReplayEvent(float(flight.t[deepest[row]]), words)
    for one in verdict.findings:
        yield ReplayEvent(one.t, one.words)
