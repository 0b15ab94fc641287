"""Policy on falls: no vehicle whose setpoint or plan is above the floor touches it."""

from collections.abc import Iterator

import numpy as np

from q2q_model.signals.values import Mask, Rows
from q2q_sim.monitors.policies.exemptions.dead_reckoned_descent import ends_dead_reckoned_descent
from q2q_sim.monitors.policies.exemptions.feedback_loss import sent_down_lately
from q2q_sim.monitors.policies.exemptions.unpredicted_downwash import exempt_lately
from q2q_sim.monitors.policies.inputs.circumstances import Circumstances
from q2q_sim.monitors.policies.inputs.flight_trace import FlightTrace
from q2q_sim.monitors.policies.inputs.limits import Limits
from q2q_sim.monitors.policies.violations import Violation


def floor(trace: FlightTrace, circumstances: Circumstances) -> list[Violation]:
    """Return the first fall of each vehicle that was not commanded to land or cut."""
    z, limit = trace.true_pos[..., 2], circumstances.limits.floor
    return [
        Violation("floor", trace.names[row], float(trace.t[k]), float(z[k, row]), limit)
        for row, (k, *_) in falls(trace, circumstances).items()
    ]


def falls(trace: FlightTrace, circumstances: Circumstances) -> dict[int, list[int]]:
    """Return the ticks at which falls of a vehicle reach the floor, by the row of each that falls.

    Take-off and landing are not falls: there the plan is near the floor. Nor is it a fall that a command
    could prevent if the vehicle is uncontrollable (thrust_exceeded, unpredicted_downwash). A vehicle
    that was sent down is exempt where that brought it down (dead_reckoned_descent). One that still lies there
    when its exemption ends has fallen, at the time of the contact.
    """
    limits = circumstances.limits
    sent_down = sent_down_lately(trace, limits.settle)
    exempt = exempt_lately(trace, circumstances)

    def is_exempt(contact: Rows, row: int) -> bool:
        is_brought = ends_dead_reckoned_descent(trace, row, int(contact[0]), limits.settle)
        return bool((exempt[contact, row] | (is_brought & sent_down[contact, row])).all())

    found = {
        row: [int(one[0]) for one in _contacts(trace, row, limits) if not is_exempt(one, row)]
        for row in range(len(trace.names))
    }
    return {row: ticks for row, ticks in found.items() if ticks}


def touches_floor(trace: FlightTrace, limits: Limits) -> Mask:
    """Return which vehicles are on the floor though they are sent above it, or were led down, (T, n)."""
    on_floor = trace.true_pos[..., 2] <= limits.floor
    sent_above = trace.sent_pos[..., 2] > limits.take_off
    return np.asarray(on_floor & (sent_above | _is_led_down(trace, limits)))


def _is_led_down(trace: FlightTrace, limits: Limits) -> Mask:
    """Return whose plan has been above the floor ever since they flew last, (T, n).

    Setpoints of a replanner below such a plan excuse no fall. While a vehicle takes off, they may be behind a
    plan that jumps.
    """
    ticks = np.arange(len(trace.t))[:, None]
    flies = trace.true_pos[..., 2] > limits.take_off
    asked_above = trace.asked_pos[..., 2] > limits.take_off
    flown_last, low_last = (
        np.maximum.accumulate(np.where(found, ticks, -1)) for found in (flies, ~asked_above)
    )
    return np.asarray(flown_last > low_last)


def _contacts(trace: FlightTrace, row: int, limits: Limits) -> Iterator[Rows]:
    """Yield the ticks on the floor of each contact of a vehicle; it ends above the height of take-off."""
    ticks = np.flatnonzero(touches_floor(trace, limits)[:, row])
    risen = np.cumsum(trace.true_pos[:, row, 2] > limits.take_off)[ticks]
    for part in np.split(ticks, np.flatnonzero(np.diff(risen)) + 1):
        if len(part):
            yield part
