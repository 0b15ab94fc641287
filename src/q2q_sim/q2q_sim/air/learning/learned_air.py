"""Air of a room learned from its recorded flights, term by term.

flights -> records -> rate load -> jet -> absorption -> residual, edge torque -> ground, wind, vehicle
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeVar

from q2q_model.flights.duplicates.same_flight import flight_digest
from q2q_model.recordings.flight_recording import Recording
from q2q_model.vehicle.constants import Vehicle
from q2q_sim.air.air_terms import AbsorptionTerm, EdgeTorqueTerm, JetTerm, RateLoadTerm, ResidualTerm
from q2q_sim.air.learning.absorption_term import absorption_term, sum_of_two
from q2q_sim.air.learning.edge_torque_term import edge_torque_term
from q2q_sim.air.learning.ground_term import ground_term
from q2q_sim.air.learning.jet.jet_table import momentum_share
from q2q_sim.air.learning.jet.jet_term import REFERENCE, jet_term
from q2q_sim.air.learning.jet.leave_one_group_out import held_out_groups
from q2q_sim.air.learning.jet.plausibility import doubts, reject_excess, reject_lift
from q2q_sim.air.learning.lateral_push import lateral_push
from q2q_sim.air.learning.rate_load_term import rate_load_term
from q2q_sim.air.learning.records.air_record import AirRecord, air_records
from q2q_sim.air.learning.residual.residual_term import residual_term
from q2q_sim.air.learning.rotor_drag_term import rotor_drag_term
from q2q_sim.air.learning.statistics.fitted import Fitted, LearnedTerm
from q2q_sim.air.learning.vehicle_term import accelerometer_reason, hovering_mass, vehicle_term
from q2q_sim.air.learning.wind_term import wind_term
from q2q_sim.air.room_air import RoomAir

T = TypeVar("T")
OnStep = Callable[[str], None]


@dataclass(frozen=True, slots=True)
class LearnedAir:
    """Air of a room with what it was learned from."""

    air: RoomAir
    values: tuple[Fitted, ...]
    checks: tuple[Fitted, ...]
    """Measured values that no term has."""
    notes: tuple[str, ...]
    """One sentence on each flight left out and each absent term."""
    doubts: tuple[str, ...]
    """One sentence on each check that is not as expected."""


@dataclass(frozen=True, slots=True)
class _Wakes:
    """Terms that act under another vehicle."""

    jet: LearnedTerm[JetTerm] | None = None
    absorption: LearnedTerm[AbsorptionTerm] | None = None
    residual: LearnedTerm[ResidualTerm] | None = None
    edge_torque: LearnedTerm[EdgeTorqueTerm] | None = None
    checks: tuple[Fitted, ...] = ()


def learn_air(recordings: Sequence[Recording], vehicle: Vehicle, on_step: OnStep) -> LearnedAir:
    """Return the air of recorded flights; `on_step` is called with the name of each step at its start.

    Raises:
        ValueError: no flight has a usable row, or the push is that of another sign or unit.
    """
    on_step("records")
    records, notes = air_records(recordings, vehicle, vehicle.thrust_lag)
    if not records:
        raise ValueError("; ".join(notes))
    load = rate_load_term(records, vehicle)
    wakes = _wakes(records, vehicle, _term(load), on_step)
    on_step("ground, wind and vehicles")
    ground, wind, vehicles = ground_term(records), wind_term(records), vehicle_term(records, vehicle)
    drag = rotor_drag_term(records)
    acting = (wakes.jet, wakes.absorption, wakes.residual, wakes.edge_torque)
    learned = (*acting, ground, wind, vehicles, drag, load)
    values = tuple(value for one in learned if one for value in one.values)
    air = RoomAir(
        jet=_term(wakes.jet),
        absorption=_term(wakes.absorption),
        residual=_term(wakes.residual),
        edge_torque=_term(wakes.edge_torque),
        ground=ground.term,
        wind=_term(wind),
        vehicle=_term(vehicles),
        rotor_drag=_term(drag),
        rate_load=_term(load),
        flights=tuple(used := {record.name: None for record in records}),
        digests=tuple(flight_digest(one.flight) for one in recordings if one.flight.name in used),
        intervals={one.path: ends for one in values if (ends := one.ends)},
    )
    absent = _absent(records, air, vehicle)
    doubted = (*doubts(values, wakes.checks), *filter(None, [accelerometer_reason(records)]))
    return LearnedAir(air, values, wakes.checks, (*notes, *absent), doubted)


def _wakes(
    records: Sequence[AirRecord], vehicle: Vehicle, load: RateLoadTerm | None, on_step: OnStep
) -> _Wakes:
    on_step("jet")
    reject_lift(records)
    jet = jet_term(records)
    if jet is None:
        return _Wakes()
    reject_excess(jet.term)
    on_step("absorption and residual")
    absorption = absorption_term(records, jet.term)
    residual = residual_term(held_out_groups(records, jet.term), _term(absorption))
    on_step("edge torque")
    torque = edge_torque_term(records, jet.term, vehicle, load.nms if load else 0.0)
    share = momentum_share(jet.term, REFERENCE)
    momentum = Fitted("momentum of one jet", share, None, None, 0, "1: four rotor disks take all of m g")
    checks = (momentum, sum_of_two(records, jet.term), lateral_push(records, jet.term))
    return _Wakes(jet, absorption, residual, torque, tuple(check for check in checks if check))


def _term(learned: LearnedTerm[T] | None) -> T | None:
    return None if learned is None else learned.term


def _absent(records: Sequence[AirRecord], air: RoomAir, vehicle: Vehicle) -> list[str]:
    """Return one sentence on the flights of one vehicle, and on each term that the flights do not show."""
    alone = [record.name for record in records if record.vehicles < 2]
    reasons = {
        "jet": "too few rows lie under another vehicle",
        "absorption": "too few rows lie under two vehicles",
        "residual": "too few rows lie under another vehicle",
        "edge_torque": "too few rows with motor duties, rates and attitude under another vehicle",
        "wind": "too few rows in clear air",
        "rotor_drag": "no vehicle moves in clear air with an accelerometer",
        "rate_load": "no vehicle turns in clear air with a log of motors and rates",
        "vehicle": _no_vehicle(records, vehicle),
    }
    notes = [
        f"no {term.replace('_', ' ')}: {why}" for term, why in reasons.items() if getattr(air, term) is None
    ]
    return [f"{', '.join(alone)}: one vehicle, no wake", *notes] if alone else notes


def _no_vehicle(records: Sequence[AirRecord], vehicle: Vehicle) -> str:
    mass = hovering_mass(records, vehicle)
    if reason := accelerometer_reason(records):
        return reason
    if mass is None:
        return "too few flights with clear air, an accelerometer and commanded thrust"
    return (
        f"{vehicle.name} weighs {1e3 * vehicle.mass:.1f} g, but the thrust commands of these flights carry "
        f"{1e3 * mass:.1f} g: give the vehicle that was flown (--vehicle)"
    )
