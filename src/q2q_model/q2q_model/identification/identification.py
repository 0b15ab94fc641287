"""Identification procedure, from recorded flights to gains, zone and model: sections 2.2 to 3.2 in order.

flights -> repaired records -> gains (12)-(13) -> pushes -> dev, alpha, beta, d -> candidates for eta
-> held-out errors -> the model, fitted on all flights -> its zone |eta| >= threshold
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import chain

import numpy as np

from q2q_model.downwash.interaction_model import InteractionModel
from q2q_model.downwash.level_set import LevelSet, level_set
from q2q_model.flights.flight_log import FlightLog, log_at
from q2q_model.flights.same_flight import flight_digest
from q2q_model.geometry.zone import Cylinder
from q2q_model.identification.deviation import DecayFit, fit_decay
from q2q_model.identification.gain_notes import gain_notes
from q2q_model.identification.gains.altitude_from_flight import altitude_records
from q2q_model.identification.gains.altitude_record import AltitudeRecord
from q2q_model.identification.gains.command_gains import GainFit, gains_from_commands
from q2q_model.identification.gains.impulse_response import with_added_acc
from q2q_model.identification.gains.trajectory_gains import OFFSET, gains_from_trajectories, is_better
from q2q_model.identification.identification_data import IdentificationData, largest_gap
from q2q_model.identification.intervals import Interval
from q2q_model.identification.push.loading import loading_of
from q2q_model.identification.push.push_samples import PushSamples, push_samples
from q2q_model.identification.push.recorded_push import lag_note, push_record
from q2q_model.identification.push.residual_fit import ResidualFit, fit_residual
from q2q_model.identification.push.sensor_check import sensor_notes
from q2q_model.identification.selection.candidates import (
    NOTHING,
    Candidate,
    Trial,
    candidates,
    fit_best,
    network_notes,
    parameter_intervals,
    score_candidates,
    with_deviation,
)
from q2q_model.identification.selection.cross_validation import Score, model_doubts, score_on
from q2q_model.model_files.model_file import Fit, ModelFile
from q2q_model.recordings.flight_recording import Recording
from q2q_model.vehicle.altitude_loop import AltitudeLoop
from q2q_model.vehicle.constants import CRAZYFLIE_2_0, Vehicle

StepCallback = Callable[[str], None]

FEED_FORWARD = "fa_ff"
"""Log column of the downwash force that the controller compensated [N]."""


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
        ValueError: a flight lacks data that a step needs; the message names what to record.
    """
    on_step("records")
    flown, holes = zip(*(recorded_altitudes(one, params.vehicle) for one in recordings), strict=True)
    on_step("gains")
    records = [*chain(*flown)]
    gains, remarks = _gains(records, recordings, params.vehicle)
    loop, known = _loop(gains, flown, params.vehicle)
    on_step("pushes")
    pushes, notes = _pushes(recordings, params.vehicle)
    pushed = [sample for samples in pushes for sample in samples]
    data = [IdentificationData(*pair) for pair in zip(known, pushes, strict=True)]
    on_step("zone")
    decay, no_decay = _decay(records)
    omitted = network_notes(params.model_type, data)
    tried = candidates(params.model_type, data, loop)
    trials, failed = score_candidates(tried, data, loop, on_step)
    on_step("final fit")
    best, model, unfit = fit_best(trials, data, failed)
    model = with_deviation(best.candidate, model, data)
    zone, on_zone = _learned_zone(model, params.threshold, records)
    doubted = model_doubts(gains, best.held_out, data) if best.candidate.kind != NOTHING.kind else []
    train = score_on(model, data, loop)
    spread = parameter_intervals(best.candidate, model, data, loop)
    return Identification(
        data=tuple(data),
        gains=gains,
        decay=decay,
        trials=tuple(trials),
        chosen=best.candidate,
        train=train,
        held_out=best.held_out,
        spread=spread,
        loading=dict(spread).get("loading") or loading_of(model, pushed),
        residual=(residual := fit_residual(model, pushed)),
        zone=zone,
        file=_file(model, zone, loop if gains.holds else None, residual, _fit(best, train, recordings)),
        remarks=tuple(chain(*holes, remarks, notes, no_decay, omitted, failed, unfit, on_zone, doubted)),
    )


def _loop(
    gains: GainFit, flown: Sequence[tuple[AltitudeRecord, ...]], vehicle: Vehicle
) -> tuple[AltitudeLoop, Sequence[tuple[AltitudeRecord, ...]]]:
    """Return the loop that predicts altitudes, and the records with what commands show besides."""
    if not gains.from_commands:
        return gains.loop, flown
    loop = replace(gains.loop, lag=vehicle.thrust_lag, offset=0.0)
    return loop, [
        tuple(with_added_acc(one, loop, gains.compensated, gains.of_rates) for one in pieces)
        for pieces in flown
    ]


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


def recorded_altitudes(
    one: Recording, vehicle: Vehicle
) -> tuple[tuple[AltitudeRecord, ...], tuple[str, ...]]:
    """Return a flight's records, with the feed-forward of its log if that has one, and remarks."""
    records, holes = altitude_records(one.flight, vehicle)
    return tuple(_with_feed_forward(record, one.log, vehicle) for record in records), tuple(holes)


def _with_feed_forward(record: AltitudeRecord, log: FlightLog | None, vehicle: Vehicle) -> AltitudeRecord:
    if log is None or FEED_FORWARD not in log.columns:
        return record
    logged = np.flatnonzero(np.isfinite(log.values).any(axis=(1, 2)))
    if not logged.size:
        return record
    at = np.searchsorted(log.t[logged], record.t - 0.5 * record.dt)
    rows = logged[np.clip(at, 0, logged.size - 1)]
    column = log_at(log, log.t, record.names).column(FEED_FORWARD)
    return replace(record, feed_forward=column[rows] / vehicle.mass)


def _pushes(
    recordings: Sequence[Recording], vehicle: Vehicle
) -> tuple[list[tuple[PushSamples, ...]], list[str]]:
    """Return the samples of every flight, and notes on their push."""
    records = [push_record(one, vehicle, vehicle.thrust_lag) for one in recordings]
    pushes = [tuple(push_samples(record)) if record is not None else () for record in records]
    sampled = [one for one, samples in zip(recordings, pushes, strict=True) if samples]
    notes = sensor_notes([one.flight for one in recordings], vehicle)
    return pushes, [*notes, *lag_note(sampled, vehicle.thrust_lag)]


def _gains(
    records: Sequence[AltitudeRecord], recordings: Sequence[Recording], vehicle: Vehicle
) -> tuple[GainFit, list[str]]:
    try:
        fit = gains_from_commands(records)
        return fit, gain_notes(fit, recordings, vehicle)
    except ValueError as missing:
        found, shifted = gains_from_trajectories(records), gains_from_trajectories(records, (OFFSET,))
        if needs_offset := is_better(shifted, found):
            found = shifted
        spread = dict(found.intervals)
        fit = GainFit(
            loop=found.loop,
            k_p=spread["k_p"],
            k_d=spread["k_d"],
            needs_offset=needs_offset,
            needs_integral=False,
            rms=found.rms,
            from_commands=False,
        )
        notes = [f"gains are from trajectories, downwash and lag included: {missing}"]
        return fit, [*notes, *_feed_forward_note(records)]


def _feed_forward_note(records: Sequence[AltitudeRecord]) -> list[str]:
    """Return a note if a controller may have compensated downwash, and no commands show how much of it."""
    if not any((np.nan_to_num(record.feed_forward) != 0.0).any() for record in records):
        return []
    return [
        (
            "the topic interference is recorded, but no commands: if the controller compensated it, the "
            "model has what was left of it; record the topic command"
        )
    ]


def _decay(records: Sequence[AltitudeRecord]) -> tuple[DecayFit | None, list[str]]:
    try:
        decay = fit_decay(records)
    except ValueError as missing:
        return None, [f"no zone from dev: {missing}"]
    flown = max(overlap.gap for overlap in decay.overlaps)
    if decay.extrapolated:
        return decay, [
            f"d = {decay.d.value:.2f} m lies beyond the largest gap flown, {flown:.2f} m: it is extrapolated"
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
