"""Compiled loops of `q2q_sim.link.radio`: round, send and deliver packets.

| name | meaning [unit] |
|---|---|
| when | arrival [ns] and vehicle of each packet in the air, in the order they were sent, (capacity, 2) |
| what | thrust [N], roll, pitch [rad], yaw rate [rad/s] of each, (capacity, 4) |
| next_ns | when each vehicle may be sent the next packet [ns], (n,) |
| received_ns | when each vehicle received the last one [ns], (n,) |
| locked | vehicles whose thrust is locked, (n,) |
| applied | setpoint of each vehicle, columns as `what`, (n, 4) |

Python passes plain tuples: numba takes named ones in three times the time.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from q2q_model.compiled import compiled
from q2q_model.signals.values import Array, Mask, Rows
from q2q_model.vehicle.setpoint_watchdog import CUT_AFTER_S, LEVEL_AFTER_S
from q2q_model.vehicle.thrust_map import PWM_FULL, RPYT_PWM_MAX, RPYT_PWM_MIN

DEGREES, RADIANS = 180.0 / math.pi, math.pi / 180.0
"""Degrees in a radian, and radians in a degree."""

LEVEL_AFTER_NS, CUT_AFTER_NS = round(LEVEL_AFTER_S * 1e9), round(CUT_AFTER_S * 1e9)
"""[ns]"""

Nanoseconds = NDArray[np.int64]
Flying = tuple[Nanoseconds, Array]
"""when, what."""
Counted = tuple[Nanoseconds, Array, int]
"""when, what, and the number of packets in the air."""
TickCommands = tuple[Array, float, float]
"""Commands of a tick, (4, k); largest thrust, and thrust at PWM_FULL, of which 0 rounds nothing [N]."""
Transmitter = tuple[Rows, Nanoseconds, Mask]
"""Vehicle of each command; next_ns; jammed vehicles, which lose their packets, (n,)."""
PacketLoss = tuple[Array, float, Array, float]
"""Random numbers from 0 to 1 and the share of packets lost, (n,); others and the largest delay beyond the
latency [ns], (n,)."""
Onboard = tuple[Nanoseconds, Mask, Array]
"""Fields of OnboardReceivers."""


class OnboardReceivers(NamedTuple):
    """State of the vehicles' receivers."""

    received_ns: Nanoseconds
    locked: Mask
    applied: Array


@compiled
def round_packets(values: Array, full_pwm_thrust: float, out: Array) -> None:
    """Write commands as vehicles read them in packets: integer PWM, and 32-bit floats in degrees.

    The numbers are those of q2q_control.radio.link.rpyt_scale, which takes numpy's calls: ten times as long.

    Args:
        values: commands, rows as the columns of `what`, (4, k).
        full_pwm_thrust: collective thrust at PWM_FULL [N].
        out: written, (4, k).
    """
    for k in range(values.shape[1]):
        pwm = min(max(np.rint(values[0, k] / full_pwm_thrust * PWM_FULL), 0.0), RPYT_PWM_MAX)
        out[0, k] = pwm / PWM_FULL * full_pwm_thrust if pwm >= RPYT_PWM_MIN else 0.0
        for c in range(1, 4):
            out[c, k] = np.float64(np.float32(values[c, k] * DEGREES)) * RADIANS


@compiled
def send_packets(
    flying: Counted,
    commands: TickCommands,
    sent: Transmitter,
    chance: PacketLoss,
    clock: tuple[int, int, int],
) -> int:
    """Send packets; return how many are in the air then.

    Args:
        flying: packets in the air, and their number.
        commands: commands of the tick.
        sent: state of the transmitter.
        chance: what is lost and late at random.
        clock: now, gap between packets of a vehicle, latency [ns].
    """
    when, what, count = flying
    values, thrust_max, full_pwm_thrust = commands
    if full_pwm_thrust > 0.0:
        exact, values = values, np.empty_like(values)
        round_packets(exact, full_pwm_thrust, values)
    (rows, next_ns, jammed), (drawn, loss, later, jitter_ns) = sent, chance
    now_ns, gap_ns, latency_ns = clock
    for k in range(rows.size):
        row = rows[k]
        if next_ns[row] > now_ns:
            continue
        next_ns[row] = max(next_ns[row], now_ns - gap_ns) + gap_ns
        if jammed[row] or drawn[row] < loss:
            continue
        when[count, 0], when[count, 1] = now_ns + latency_ns + int(np.rint(later[row] * jitter_ns)), row
        what[count, 0] = min(max(values[0, k], 0.0), thrust_max)
        for c in range(1, 4):
            what[count, c] = values[c, k]
        count += 1
    return count


@compiled
def run_watchdog(onboard: OnboardReceivers, now_ns: int) -> None:
    """Level vehicles that have received nothing for LEVEL_AFTER_NS; cut their motors after CUT_AFTER_NS."""
    for i in range(onboard.received_ns.size):
        silent_ns = now_ns - onboard.received_ns[i]
        if silent_ns > LEVEL_AFTER_NS:
            onboard.applied[i, 1:] = 0.0
        if silent_ns > CUT_AFTER_NS:
            onboard.applied[i, 0] = 0.0
            onboard.locked[i] = True


@compiled
def deliver_packets(flying: Flying, count: int, onboard: Onboard, clock: tuple[int, int], out: Array) -> int:
    """Write each vehicle's setpoint in each physics step of a tick; return how many packets stay in the air.

    Args:
        flying: packets in the air.
        count: number of them.
        onboard: state of the receivers.
        clock: now, length of a step [ns].
        out: setpoints, (steps, n, 4).
    """
    when, what = flying
    received_ns, locked, applied = onboard
    now_ns, step_ns = clock
    run_watchdog(OnboardReceivers(received_ns, locked, applied), now_ns)
    steps, left = out.shape[0], 0
    for s in range(steps):
        out[s] = applied
    for k in range(count):
        arrival_ns, row = when[k, 0], when[k, 1]
        if arrival_ns > now_ns + (steps - 1) * step_ns:
            when[left], what[left] = when[k], what[k]
            left += 1
            continue
        locked[row] = locked[row] and what[k, 0] > 0.0
        received_ns[row] = max(arrival_ns, now_ns)
        for s in range(max(-((now_ns - arrival_ns) // step_ns), 0), steps):  # from arrival on
            out[s, row] = what[k]
            if locked[row]:
                out[s, row, 0] = 0.0
    applied[:] = out[steps - 1]
    return left
