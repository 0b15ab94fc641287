"""Policies on positions: near the setpoint, true to the state estimate, back on the path after faults."""

import numpy as np

from q2q_model.flights.masks_over_time import last_row, runs_of_true
from q2q_model.signals.values import Array, CommandStatus, Mask, TrackStatus
from q2q_sim.faults.faults import Fault
from q2q_sim.monitors.policies.exemptions.feedback_loss import (
    evading_lately,
    sent_down_lately,
    without_feedback,
    without_feedback_lately,
)
from q2q_sim.monitors.policies.exemptions.sensor_errors import (
    RECOVERY_S,
    marker_displacement,
    with_sensor_error,
)
from q2q_sim.monitors.policies.exemptions.unpredicted_downwash import exempt_lately
from q2q_sim.monitors.policies.inputs.circumstances import Circumstances
from q2q_sim.monitors.policies.inputs.flight_trace import FlightTrace
from q2q_sim.monitors.policies.inputs.limits import Limits
from q2q_sim.monitors.policies.violations import Violation, worst_violations


def setpoint_error(trace: FlightTrace, circumstances: Circumstances) -> list[Violation]:
    """Return the vehicles that flew away from their setpoints.

    A displaced marker displaces the vehicle: the allowed distance grows by as much. An uncontrollable vehicle
    sinks: it is not judged until `settle` after it.
    """
    off = setpoint_distances(trace, circumstances.limits)
    off = np.maximum(off - marker_displacement(trace, circumstances.faults), 0.0)
    limit = circumstances.limits.setpoint_error_max
    excess = np.where(exempt_lately(trace, circumstances), np.nan, off - limit)
    return worst_violations("setpoint_error", trace, excess, (off, limit))


def setpoint_distances(trace: FlightTrace, limits: Limits) -> Array:
    """Return how far the vehicles are from their setpoints [m], (T, n).

    A vehicle that lands without measurements goes to the floor, up to 2 m below its setpoint in these rooms:
    being lower does not count then, nor for `settle` after it while it climbs again. A lost vehicle stops,
    and one that evades it is held back, while their setpoints go on: until `settle` after it, the distance
    beyond the limit is that from the nearest of the setpoints since.
    """
    down = sent_down_lately(trace, limits.settle)
    off = _distance(trace.true_pos - trace.sent_pos, down)
    stopped = without_feedback_lately(trace, limits.settle) | evading_lately(trace, limits.settle)
    for row in range(len(trace.names)):
        for begin, end in runs_of_true(stopped[:, row]):
            late = begin + np.flatnonzero(off[begin:end, row] > limits.setpoint_error_max)
            off_by = trace.true_pos[late, None, row] - trace.sent_pos[begin:end, row]  # (late, run, 3)
            apart = _distance(off_by, down[late, None, row])
            apart[late[:, None] < np.arange(begin, end)] = np.inf
            off[late, row] = np.fmin.reduce(apart, axis=1)
    return off


def _distance(off_by: Array, down: Mask) -> Array:
    """Return distances [m], (...), of vectors (..., 3); below does not count where `down`."""
    x, y, z = off_by[..., 0], off_by[..., 1], off_by[..., 2]
    z = np.where(down, np.maximum(z, 0.0), z)
    return np.asarray(np.sqrt(x * x + y * y + z * z))


def state_error(trace: FlightTrace, circumstances: Circumstances) -> list[Violation]:
    """Return the vehicles whose state was wrong under the status tracked."""
    off = np.linalg.norm(trace.state_pos - trace.true_pos, axis=2)
    trusted = (trace.state_status == TrackStatus.TRACKED) & ~with_sensor_error(
        trace, circumstances.faults, RECOVERY_S
    )
    limit = circumstances.limits.state_error_max
    return worst_violations("state_error", trace, np.where(trusted, off - limit, np.nan), (off, limit))


def return_to_path(trace: FlightTrace, circumstances: Circumstances) -> list[Violation]:
    """Return the vehicles not back on their path `settle` after the last fault.

    A replanned motion that accelerates leaves its vehicle behind for a moment: what counts is the least
    distance within `passing`. Where positions or setpoints are missing for no longer, the last one counts.
    A vehicle that is uncontrollable has `settle` then.
    """
    limits = circumstances.limits
    exempt = exempt_lately(trace, circumstances)
    calm = trace.t > last_fault_end(trace, circumstances.faults) + limits.settle
    cut = (trace.command_status == CommandStatus.CUT).any(axis=0)  # landed, and stay on the ground
    off = np.linalg.norm(trace.true_pos - trace.sent_pos, axis=2)
    judged = np.where(calm[:, None] & ~cut & ~exempt, off, -np.inf)
    ticks = max(round(limits.passing / trace.tick), 1)
    lasting = _least_before(_across_gaps(judged, ticks), ticks)
    return worst_violations("return", trace, lasting - limits.back, (lasting, limits.back))


def _across_gaps(values: Array, ticks: int) -> Array:
    """Return values (T, n) with the last one in gaps, NaN, that end within `ticks` of it."""
    count, known = np.arange(len(values))[:, None], ~np.isnan(values)
    last = last_row(known)
    following = np.minimum.accumulate(np.where(known, count, len(values) + ticks)[::-1], axis=0)[::-1]
    short = (last >= 0) & (following - last <= ticks)
    return np.where(short, np.take_along_axis(values, last, axis=0), values)


def _least_before(values: Array, ticks: int) -> Array:
    """Return the least of the last `ticks` values of (T, n) at each, (T, n); -inf where there are fewer."""
    least, spanned = values, 1
    while spanned < ticks:
        earlier, step = np.full_like(values, -np.inf), min(spanned, ticks - spanned)
        earlier[step:] = least[:-step]
        least, spanned = np.minimum(least, earlier), spanned + step
    return least


def last_fault_end(trace: FlightTrace, faults: tuple[Fault, ...]) -> float:
    """Return the time of the last fault or fallback command [s]; -inf without any."""
    wrong = without_feedback(trace).any(axis=1)
    noted = [float(trace.t[wrong][-1])] if wrong.any() else []
    return max([*noted, *(_end(fault) for fault in faults)], default=-np.inf)


def _end(fault: Fault) -> float:
    return fault.start + fault.duration
