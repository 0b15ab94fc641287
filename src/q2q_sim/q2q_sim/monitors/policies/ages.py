"""Policies on time: age of the states behind commands, time to the fallback, gaps between commands.

A command counts as computed from a fresh state if its status is OK or SATURATED; every other status, and a
missing command, counts as a fallback (q2q_control.failsafe.fallback_phases).
"""

import numpy as np
from numpy.typing import NDArray

from q2q_model.flights.masks_over_time import last_time
from q2q_model.signals.stamps import SAME_STAMP
from q2q_model.signals.values import Array, CommandStatus
from q2q_sim.monitors.policies.exemptions.sensor_errors import after_label_swap, with_doubtful_stamps
from q2q_sim.monitors.policies.inputs.circumstances import Circumstances
from q2q_sim.monitors.policies.inputs.flight_trace import FlightTrace
from q2q_sim.monitors.policies.inputs.limits import Limits
from q2q_sim.monitors.policies.violations import Violation, worst_violations


def state_age(trace: FlightTrace, circumstances: Circumstances) -> list[Violation]:
    """Return the vehicles flown normally on too old a state."""
    limit = circumstances.limits.state_age_max
    excess = np.where(_as_usual(trace), trace.state_age - limit - SAME_STAMP, np.nan)
    return worst_violations("state_age", trace, excess, (trace.state_age, limit))


def fallback_latency(trace: FlightTrace, circumstances: Circumstances) -> list[Violation]:
    """Return the vehicles flown normally though not in any frame for longer than a fallback may take.

    Stamps are the only clock: frames with jumping stamps cannot be dated, so the time without observation
    starts again after a clock jump. Vehicles whose names are exchanged are observed as each other: which of
    them is missing is unknown then.
    """
    limit = circumstances.limits.fallback_latency_max
    if not trace.seen.any():
        return []  # no motion capture in this recording
    seen = trace.seen | with_doubtful_stamps(trace, circumstances.faults)[:, None]
    unseen = trace.t[:, None] - np.maximum(last_time(seen, trace.t), trace.t[0])
    reported = _as_usual(trace) & ~after_label_swap(trace, circumstances.faults)
    excess = np.where(reported, unseen - limit - SAME_STAMP, np.nan)
    return worst_violations("fallback_latency", trace, excess, (unseen, limit))


def silence(trace: FlightTrace, circumstances: Circumstances) -> list[Violation]:
    """Return the longest silence of each vehicle of a live flight, if longer than a fallback may take.

    What ends it is a command with a new stamp. From the last one on, it lasts until the vehicle's last
    position. A vehicle on the ground needs no commands, nor does one that comes down without: it has landed,
    its own commander lands it, or the policy on the floor shows that it falls.
    """
    if not trace.live:
        return []
    found = []
    for row, name in enumerate(trace.names):
        begin, silent = _silences(trace, row, circumstances.limits)
        limit = np.full(len(begin), circumstances.limits.fallback_latency_max)
        limit[-1:] = circumstances.limits.ended
        if len(begin):
            k = int((silent - limit).argmax())
            stamp = float(trace.t[np.abs(trace.recorded_at - begin[k]).argmin()])
            worst = Violation("silence", name, stamp, float(silent[k]), float(limit[k]))
            found += [worst] if worst.value > worst.limit else []
    return found


def _silences(trace: FlightTrace, row: int, limits: Limits) -> tuple[Array, Array]:
    """Return when each new command of a vehicle came [s], (K,), and for how long none followed in the air."""
    begin = trace.commanded_at.get(trace.names[row], np.zeros(0))
    height, at = trace.true_pos[:, row, 2], trace.recorded_at
    last = max((*begin[-1:], *at[np.isfinite(height)]), default=0.0)
    end = np.append(begin[1:], last)[: len(begin)]
    down = np.sort(at[height <= limits.take_off])
    landed = np.searchsorted(down, end, "right") > np.searchsorted(down, begin, "left")
    return begin, np.where(landed, 0.0, end - begin)


def _as_usual(trace: FlightTrace) -> NDArray[np.bool_]:
    return np.asarray(trace.command_status <= CommandStatus.SATURATED)
