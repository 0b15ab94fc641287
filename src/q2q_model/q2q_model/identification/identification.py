"""Identification procedure, from recorded flights to gains, zone and model: sections 2.2 to 3.2 in order.

flights -> repaired records -> gains (12)-(13) -> pushes -> dev, alpha, beta, d -> candidates for eta
-> held-out errors -> the model, fitted on all flights -> its zone |eta| >= threshold
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import chain

from q2q_model.downwash.interaction_model import InteractionModel
from q2q_model.downwash.level_set import LevelSet, level_set
from q2q_model.flights.duplicates.same_flight import flight_digest
from q2q_model.geometry.zone import Cylinder
from q2q_model.identification.deviation import DecayFit, Overlap, fit_decay, overlaps_of
from q2q_model.identification.gain_notes import unstable_reason
from q2q_model.identification.gains.altitude_record import AltitudeRecord
from q2q_model.identification.gains.command_gains import GainFit
from q2q_model.identification.jet.loading import loading_of
from q2q_model.identification.jet.residual_fit import ResidualFit, fit_residual
from q2q_model.identification.push.log_check import log_notes
from q2q_model.identification.push.log_column_note import log_column_notes
from q2q_model.identification.push.push_samples import push_samples
from q2q_model.identification.push.rate_check import rate_notes
from q2q_model.identification.push.recorded_push import lag_note, push_record
from q2q_model.identification.push.sensor_check import sensor_notes
from q2q_model.identification.recorded_altitudes import recorded_altitudes
from q2q_model.identification.recorded_gains import predicting_loop, recorded_gains
from q2q_model.identification.selection.candidate import Candidate
from q2q_model.identification.selection.candidates_of_kind import candidates
from q2q_model.identification.selection.cross_validation import Score, score_on
from q2q_model.identification.selection.identification_data import (
    IdentificationData,
    every_record,
    has_exposure,
    largest_gap,
    measures_downwash,
)
from q2q_model.identification.selection.jet_candidates import parameter_intervals, with_deviation
from q2q_model.identification.selection.model_choice import Trial, fit_best, score_candidates
from q2q_model.identification.selection.model_doubts import Scores, model_doubts
from q2q_model.identification.selection.network_candidates import network_notes
from q2q_model.identification.selection.unused_pushes import unused_push_notes, with_unknown_strength
from q2q_model.identification.statistics.intervals import Interval
from q2q_model.model_files.model_file import Fit, ModelFile
from q2q_model.recordings.flight_recording import Recording
from q2q_model.vehicle.altitude_loop import AltitudeLoop
from q2q_model.vehicle.constants import CRAZYFLIE_2_0, Vehicle

StepCallback = Callable[[str], None]


@dataclass(frozen=True, slots=True)
class ProcedureParams:
    """Parameters of the identification procedure."""

    model_type: str = "auto"
    threshold: float = 0.1
    """|eta| on the learned zone's boundary [m/s^2]: 1 % of gravity, 5 cm after a second."""
    vehicle: Vehicle = CRAZYFLIE_2_0


@dataclass(frozen=True, slots=True)
class Identification:
    """Result of an identification."""

    data: tuple[IdentificationData, ...]
    gains: GainFit
    decay: DecayFit | None
    overlaps: tuple[Overlap, ...]
    """Deviation of each flight with overlap, also where it shows no decay."""
    trials: tuple[Trial, ...]
    chosen: Candidate
    train: Score
    held_out: Score
    spread: tuple[tuple[str, Interval], ...]
    """Intervals of the model's parameters; empty unless it is a jet."""
    loading: Interval | None
    """The model's own if that has one; None if no vehicle flew under one that was itself under another."""
    residual: ResidualFit | None
    """None for too few samples under another vehicle."""
    zone: LevelSet | None
    file: ModelFile
    remarks: tuple[str, ...]


def identify(
    recordings: Sequence[Recording], params: ProcedureParams, on_step: StepCallback
) -> Identification:
    """Return gains, zone and model of flights; `on_step` is called with the name of each step at its start.

    Raises:
        ValueError: a flight lacks data that a step needs; the message names what to record. Or the downwash
            was not measured, and gains show that z is not up. Its notes are the remarks of the steps before.
    """
    remarks: list[str] = []
    try:
        return _identified(recordings, params, on_step, remarks)
    except ValueError as refusal:
        for remark in remarks:
            refusal.add_note(remark)
        raise


@dataclass(frozen=True, slots=True)
class _Prepared:
    """Data of all flights, and the loop that predicts their altitudes."""

    records: tuple[AltitudeRecord, ...]
    gains: GainFit
    loop: AltitudeLoop
    data: tuple[IdentificationData, ...]


def _identified(
    recordings: Sequence[Recording], params: ProcedureParams, on_step: StepCallback, remarks: list[str]
) -> Identification:
    """Take the steps of the procedure; each appends its remarks to `remarks`."""
    found = _prepared(recordings, params.vehicle, on_step, remarks)
    gains, loop, data = found.gains, found.loop, found.data
    on_step("zone")
    _check_inference(gains, data)
    decay, no_decay = _decay(found.records)
    remarks += [*no_decay, *network_notes(params.model_type, data)]
    trials, failed = score_candidates(candidates(params.model_type, data, loop), data, loop, on_step)
    on_step("final fit")
    best, model, unfit = fit_best(trials, data, failed)
    model = with_deviation(best.candidate, model, data)
    zone, on_zone = _learned_zone(model, params.threshold, found.records)
    train = score_on(model, data, loop)
    spread = parameter_intervals(best.candidate, model, data, loop)
    spread = with_unknown_strength(spread, data, loop if gains.from_commands else None)
    doubts = model_doubts(gains, Scores(train, best.held_out), data, model, dict(spread))
    remarks += [*failed, *unfit, *on_zone, *doubts]
    pushes = [one for flight in data for one in flight.pushes]
    return Identification(
        data=data,
        gains=gains,
        decay=decay,
        overlaps=overlaps_of(found.records),
        trials=tuple(trials),
        chosen=best.candidate,
        train=train,
        held_out=best.held_out,
        spread=spread,
        loading=dict(spread).get("loading") or loading_of(model, pushes),
        residual=(residual := fit_residual(model, pushes)),
        zone=zone,
        file=_file(model, zone, loop if gains.holds else None, residual, _fit(best, train, recordings)),
        remarks=tuple(remarks),
    )


def _prepared(
    recordings: Sequence[Recording], vehicle: Vehicle, on_step: StepCallback, remarks: list[str]
) -> _Prepared:
    on_step("records")
    flown, holes = zip(*(recorded_altitudes(one, vehicle) for one in recordings), strict=True)
    remarks += chain(*holes)
    on_step("gains")
    records = tuple(chain(*flown))
    gains, on_gains = recorded_gains(records, recordings, vehicle)
    remarks += on_gains
    loop, known = predicting_loop(gains, flown, vehicle)
    on_step("pushes")
    measured = [push_record(one, vehicle, vehicle.thrust_lag) for one in recordings]
    pushes = [tuple(push_samples(one)) if one is not None else () for one in measured]
    data = tuple(IdentificationData(*pair) for pair in zip(known, pushes, strict=True))
    remarks += _push_notes(recordings, data, vehicle)
    remarks += unused_push_notes(measured, data, loop if gains.from_commands else None)
    return _Prepared(records, gains, loop, data)


def _check_inference(gains: GainFit, data: Sequence[IdentificationData]) -> None:
    """Raise ValueError if downwash would have to be inferred from altitudes by a loop that is not stable."""
    inferred = not measures_downwash(data) and any(has_exposure(record) for record in every_record(data))
    if inferred and (reason := unstable_reason(gains)):
        raise ValueError(f"no downwash can be inferred from altitudes, as {reason}")


def _file(
    model: InteractionModel,
    zone: LevelSet | None,
    loop: AltitudeLoop | None,
    residual: ResidualFit | None,
    fit: Fit,
) -> ModelFile:
    process = residual.process if residual else None
    return ModelFile(interaction=model, zone=zone or Cylinder(), gains=loop, fit=fit, residual=process)


def _fit(best: Trial, train: Score, recordings: Sequence[Recording]) -> Fit:
    return Fit(
        method=best.candidate.name,
        flights=tuple(one.flight.name for one in recordings),
        train_mse_m2=train.mse_m2,
        heldout_mse_m2=best.held_out.mse_m2,
        heldout_r2=best.held_out.r2,
        digests=tuple(flight_digest(one.flight) for one in recordings),
    )


def _push_notes(
    recordings: Sequence[Recording], data: Sequence[IdentificationData], vehicle: Vehicle
) -> list[str]:
    """Return notes on the measured push."""
    used = zip(recordings, data, strict=True) if measures_downwash(data) else ()
    sampled = [one for one, flight in used if flight.pushes]
    flights = [one.flight for one in recordings]
    notes = sensor_notes(flights, vehicle) + rate_notes(flights)
    notes += log_column_notes(recordings, vehicle) + log_notes(recordings, vehicle)
    return [*notes, *lag_note(sampled, vehicle.thrust_lag)]


def _decay(records: Sequence[AltitudeRecord]) -> tuple[DecayFit | None, list[str]]:
    try:
        decay = fit_decay(records)
    except ValueError as missing:
        return None, [f"no zone from dev: {missing}"]
    flown = max(overlap.gap for overlap in decay.overlaps)
    if decay.extrapolated:
        return decay, [
            f"d = {decay.d.value:.2f} m is beyond the largest average gap, {flown:.2f} m: it is extrapolated"
        ]
    return decay, []


def _learned_zone(
    model: InteractionModel, threshold: float, records: Sequence[AltitudeRecord]
) -> tuple[LevelSet | None, list[str]]:
    try:
        zone = level_set(model, threshold)
    except ValueError as empty:
        return None, [f"no zone from the learned downwash, the paper's is kept: {empty}"]
    reasons, flown = [], largest_gap(records)
    if zone.d >= model.reach.vertical:
        reasons.append(f"is the range of the model, where its downwash still exceeds {threshold:g} m/s^2")
    if zone.d > flown:
        reasons.append(f"lies beyond the largest gap flown, {flown:.2f} m: it is extrapolated")
    note = f"zone from the downwash: d = {zone.d:.2f} m {', and '.join(reasons)}"
    return zone, [note] if reasons else []
