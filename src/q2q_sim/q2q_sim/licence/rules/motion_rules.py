"""Rules of how one vehicle moves: motors, landing, locked, room, tumble, spin."""

import math

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from q2q_model.signals.values import Array, Mask
from q2q_sim.firmware.supervisor.rules import State
from q2q_sim.licence.client_commands.client_command import (
    FLIGHT,
    Asked,
    ClientCommand,
    CommandKind,
)
from q2q_sim.licence.room.licence_log import AIRBORNE, LicenceLog
from q2q_sim.licence.rules.broken_rule import (
    BrokenRule,
    broken_at,
    first_lasting_tick,
    first_tick,
)
from q2q_sim.licence.rules.licence_causes import SHUT, failure_cause
from q2q_sim.licence.rules.licence_limits import LicenceLimits

GROUND = 0.01
"""Height below which a vehicle is on the floor [m]: motors that run hold one micrometres above."""


def motors_rule(log: LicenceLog, row: int, limits: LicenceLimits) -> BrokenRule | None:
    """Return where the motors stop in the air."""
    on, height = log.running[:, row], log.pos[:, row, 2]
    ticks = round(limits.stopped_s / log.tick)
    ahead = sliding_window_view(np.append(on, np.zeros(ticks, np.bool_)), ticks)  # (T + 1, ticks)
    runs_soon = np.asarray(ahead.any(axis=-1))
    stopped = np.zeros_like(on)
    stopped[1:] = on[:-1] & ~runs_soon[1:-1] & (height[1:] > limits.drop)

    def what(tick: int) -> str:
        return f"the motors of {log.name(row)} stop at a height of {height[tick]:.2f} m"

    return broken_at(log, row, "motors", first_tick(stopped), what)


def landing_rule(log: LicenceLog, row: int, limits: LicenceLimits) -> BrokenRule | None:
    """Return where a vehicle reaches the floor too fast."""
    height, climb = log.pos[:, row, 2], log.vel[:, row, 2]
    hit = np.zeros(len(height), dtype=np.bool_)
    hit[1:] = (height[1:] <= GROUND) & (climb[:-1] < -limits.landing)

    def what(tick: int) -> str:
        return f"{log.name(row)} hits the floor at {-climb[tick - 1 : tick + 1].min():.1f} m/s"

    return broken_at(log, row, "landing", first_tick(hit), what)


def locked_rule(log: LicenceLog, row: int, limits: LicenceLimits) -> BrokenRule | None:
    """Return where the supervisor locks a vehicle in the air, or on the floor before it is to fly again.

    Not by an emergency stop of the program, nor above `drop`, where motors_rule judges.
    """
    shut = np.isin(log.state[:, row], list(SHUT))
    tick = first_tick(shut)
    if tick < 1 or log.pos[tick, row, 2] > limits.drop:
        return None
    t = float(log.t[tick])
    if log.last(row, t, lambda one: one.asked.kind == CommandKind.EMERGENCY):
        return None
    ignored = _ignored_while(log, row, shut)
    cut = log.airborne[tick - 1, row] and log.running[tick - 1, row]
    if not cut and (ignored is None or not log.flew[row]):  # one that never flew is idle
        return None
    what = f"the supervisor locks {log.name(row)} at a height of {log.pos[tick, row, 2]:.2f} m"
    then = f", and it does not follow {ignored.words}" if ignored else ""
    return BrokenRule("locked", t, f"{what}{then}", failure_cause(log, row, t + log.tick))


def _ignored_while(log: LicenceLog, row: int, shut: Mask) -> ClientCommand | None:
    """Return the first command that asks a vehicle to rise while it is shut, (T,); None if there is none."""
    for one in log.of(row):
        before = int(np.searchsorted(log.t, one.t, side="right")) - 1
        if before >= 0 and shut[before] and _asks_to_rise(one.asked):
            return one
    return None


def _asks_to_rise(asked: Asked) -> bool:
    """Return whether a vehicle on the floor is asked to fly; a landing does not ask for it."""
    lands = asked.pos is not None and asked.pos[2] <= AIRBORNE
    return asked.kind in FLIGHT and asked.lifts and not lands


def room_rule(log: LicenceLog, row: int, limits: LicenceLimits) -> BrokenRule | None:
    """Return where a vehicle leaves the room, or is asked to."""
    asked = next((one for one in log.of(row) if _leads_out(one.asked, limits)), None)
    tick = first_tick(_outside(log.pos[:, row], limits))
    left = float(log.t[tick]) if tick >= 0 else math.inf
    if asked is not None and asked.t <= left:
        what = f"{log.name(row)} is asked to leave the room"
        return BrokenRule("room", asked.t, what, asked.words_without_time)
    return broken_at(log, row, "room", tick, lambda _: f"{log.name(row)} leaves the room")


def _leads_out(asked: Asked, limits: LicenceLimits) -> bool:
    """Return whether a command asks for a place outside the room, or for a plan that leads there."""
    places = (*([] if asked.pos is None else [asked.pos]), *(asked.extent or ()))
    return bool(places) and bool(_outside(np.array(places), limits).any())


def _outside(pos: Array, limits: LicenceLimits) -> Mask:
    """Return which positions (..., 3) are outside the room; NaN is inside."""
    x, y, z = np.moveaxis(pos, -1, 0)
    beside = (np.abs(x) > limits.half_room[0]) | (np.abs(y) > limits.half_room[1])
    return np.asarray(beside | (z > limits.ceiling) | (z < -limits.depth))


def tumble_rule(log: LicenceLog, row: int, _: LicenceLimits) -> BrokenRule | None:
    """Return where the supervisor finds a vehicle tumbled."""
    tick = first_tick(log.state[:, row] == State.CRASHED)
    return broken_at(log, row, "tumble", tick, lambda _: f"{log.name(row)} tumbles")


def spin_rule(log: LicenceLog, row: int, limits: LicenceLimits) -> BrokenRule | None:
    """Return where a vehicle turns too fast."""
    spinning = log.airborne[:, row] & (np.abs(log.yaw_rate[:, row]) > limits.spin)
    tick = first_lasting_tick(spinning, round(limits.spun_s / log.tick))

    def what(tick: int) -> str:
        rate_deg = math.degrees(abs(float(log.yaw_rate[tick, row])))
        return f"{log.name(row)} spins at {rate_deg:.0f} deg/s"

    return broken_at(log, row, "spin", tick, what)
