"""Rules of a licence: what a vehicle must not do in a program's flight, and when it first did.

| rule | broken when |
|---|---|
| motors | the motors stop for 0.05 s more than 0.25 m above the floor |
| landing | a vehicle reaches the floor faster than 2.25 m/s, as after a fall from 0.25 m |
| room | it leaves the room, or is asked to, as to go more than 0.15 m below the floor |
| collision | two vehicles touch, within 0.14 m of each other; only a remark if one has lost its link |
| downwash | two fly within an ellipsoid of 0.24 and 0.6 m (vertical) for 0.3 s; nominal flight only |
| tumble | the supervisor finds a vehicle tumbled |
| setpoints | their age levels a vehicle out at least twice, for a tenth of its flight |
| spin | it turns faster than 500 deg/s for 0.2 s |
| yaw | the high-level commander, whose unit is rad, is asked for more than a turn, half a turn at once |
| command | it is asked for what no vehicle can follow (client_commands) |
| end | it still flies 5 s after the end of the program, or at the time limit |
| program | the program fails, dies, does not end, or opens more vehicles than there are |
| idle | a vehicle was asked to fly and never did, or was connected and never asked while others flew |

MotionCommander of cflib itself stops the motors 0.1 m above the floor. Between notify_setpoint_stop and the
command after it the firmware stops them, too, for a packet or two: a fall of millimetres. The ellipsoid is
that of Hoenig et al., Trajectory Planning for Quadrotor Swarms, IEEE T-RO 2018.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from q2q_model.signals.values import Array, Mask
from q2q_model.vehicle.constants import CONTACT
from q2q_sim.experiments.licence.client_commands.client_command import FLIGHT
from q2q_sim.experiments.licence.licence_causes import failure_cause
from q2q_sim.experiments.licence.licence_log import LicenceLog
from q2q_sim.experiments.licence.trials import EXCUSED, TrialKind
from q2q_sim.firmware.supervisor.rules import State

GROUND = 0.01
"""Height below which a vehicle is on the floor [m]: motors that run hold one micrometres above."""
LEVEL_SHARE = 0.1
"""Share of a flight in which a vehicle may be levelled out."""


@dataclass(frozen=True, slots=True)
class LicenceLimits:
    """Limits of the rules."""

    half_room: tuple[float, float] = (3.0, 3.0)
    """Distance of the walls from the origin along x and y [m]."""
    ceiling: float = 2.5
    """[m]"""
    depth: float = 0.15
    """Depth below the floor that may be asked for [m]: it presses a landing onto it."""
    drop: float = 0.25
    """Height above which motors must not stop [m]; cflib's full_state_setpoint_demo stops them at 0.2 m."""
    stopped_s: float = 0.05
    """Shortest stop of the motors [s]."""
    landing: float = 2.25
    """[m/s]: a fall from `drop`."""
    gap: float = CONTACT
    """Smallest distance of two vehicles [m]."""
    beside: float = 0.24
    below: float = 0.6
    """Axes of the ellipsoid of the downwash [m]."""
    exposed_s: float = 0.3
    spin: float = math.radians(500.0)
    """[rad/s]"""
    spun_s: float = 0.2
    """Shortest spin [s]: an asked step of 360 deg/s overshoots to 500 for less."""
    yaw_step: float = math.radians(185.0)
    """Largest step of an asked yaw beyond one turn [rad]: a program may count half turns in radians."""


@dataclass(frozen=True, slots=True)
class BrokenRule:
    """Broken rule."""

    rule: str
    t: float
    """[s]; 0 if nobody knows, as the process ended without a log."""
    what: str
    """What the vehicle or the program does."""
    why: str = ""
    remark: bool = False
    """It fails no flight: a vehicle that lost its link stays where it is, and others fly on as planned."""

    @property
    def sentence(self) -> str:
        """Return when, what, and why."""
        when = f"at {self.t:.2f} s " if self.t else ""
        why = f": {self.why}" if self.why else ""
        said = f"{when}{self.what}{why}"
        return f"remark: {said}" if self.remark else said


Rule = Callable[[LicenceLog, int, LicenceLimits], BrokenRule | None]


def broken_rules(log: LicenceLog, limits: LicenceLimits) -> tuple[BrokenRule, ...]:
    """Return the broken rules of a flight in the order of time."""
    found = [one for one in (_program(log), *_nearness(log, limits)) if one is not None]
    for row in range(len(log.uris)):
        if row != log.trial.excused:
            checked = [rule(log, row, limits) for rule in RULES]
            found += [one for one in checked if one is not None]
    return tuple(sorted(found, key=lambda one: one.t))


def _first(broken: Mask) -> int:
    """Return the first tick at which a condition holds; -1 if it never does."""
    return int(np.argmax(broken)) if broken.any() else -1


def _first_lasting(broken: Mask, ticks: int) -> int:
    """Return the first tick from which a condition holds for so many ticks; -1 if it never does."""
    if len(broken) < ticks:
        return -1
    return _first(np.asarray(np.convolve(broken, np.ones(ticks), mode="valid") >= ticks))


def _broken(log: LicenceLog, row: int, rule: str, tick: int, what: Callable[[int], str]) -> BrokenRule | None:
    """Return the rule that a vehicle breaks at a tick, and why; None if the tick is -1, as of `_first`."""
    if tick < 0:
        return None
    t = float(log.t[tick])
    return BrokenRule(rule, t, what(tick), failure_cause(log, row, t))


def _motors(log: LicenceLog, row: int, limits: LicenceLimits) -> BrokenRule | None:
    on, height = log.running[:, row], log.pos[:, row, 2]
    ticks = round(limits.stopped_s / float(log.t[0]))
    ahead = sliding_window_view(np.append(on, np.zeros(ticks, np.bool_)), ticks)  # (T + 1, ticks)
    runs_soon = np.asarray(ahead.any(axis=-1))
    stopped = np.zeros_like(on)
    stopped[1:] = on[:-1] & ~runs_soon[1:-1] & (height[1:] > limits.drop)

    def what(tick: int) -> str:
        return f"the motors of {log.name(row)} stop at a height of {height[tick]:.2f} m"

    return _broken(log, row, "motors", _first(stopped), what)


def _landing(log: LicenceLog, row: int, limits: LicenceLimits) -> BrokenRule | None:
    height, climb = log.pos[:, row, 2], log.vel[:, row, 2]
    hit = np.zeros(len(height), dtype=np.bool_)
    hit[1:] = (height[1:] <= GROUND) & (climb[:-1] < -limits.landing)

    def what(tick: int) -> str:
        return f"{log.name(row)} hits the floor at {-climb[tick - 1 : tick + 1].min():.1f} m/s"

    return _broken(log, row, "landing", _first(hit), what)


def _outside(pos: Array, limits: LicenceLimits) -> Mask:
    """Return which positions (..., 3) are outside the room; NaN is inside."""
    x, y, z = np.moveaxis(pos, -1, 0)
    beside = (np.abs(x) > limits.half_room[0]) | (np.abs(y) > limits.half_room[1])
    return np.asarray(beside | (z > limits.ceiling) | (z < -limits.depth))


def _room(log: LicenceLog, row: int, limits: LicenceLimits) -> BrokenRule | None:
    goals = (one for one in log.of(row) if one.asked.pos is not None)
    asked = next((one for one in goals if _outside(np.array(one.asked.pos), limits).item()), None)
    tick = _first(_outside(log.pos[:, row], limits))
    left = float(log.t[tick]) if tick >= 0 else math.inf
    if asked is not None and asked.t <= left:
        what = f"{log.name(row)} is asked to leave the room"
        return BrokenRule("room", asked.t, what, asked.words_without_time)
    return _broken(log, row, "room", tick, lambda _: f"{log.name(row)} leaves the room")


def _tumble(log: LicenceLog, row: int, _: LicenceLimits) -> BrokenRule | None:
    tick = _first(log.state[:, row] == State.CRASHED)
    return _broken(log, row, "tumble", tick, lambda _: f"{log.name(row)} tumbles")


def _setpoints(log: LicenceLog, row: int, _: LicenceLimits) -> BrokenRule | None:
    levelled = (log.state[:, row] == State.LEVEL_OUT) & log.airborne[:, row]
    begins = np.flatnonzero(levelled[1:] & ~levelled[:-1]) + 1
    share = levelled.sum() / max(int(log.airborne[:, row].sum()), 1)
    if len(begins) < 2 or share < LEVEL_SHARE:
        return None
    t = float(log.t[begins[0]])
    why = f"{len(begins)} times no setpoint came for 0.5 s, {share:.0%} of its flight"
    return BrokenRule("setpoints", t, f"the firmware levels {log.name(row)} out", why)


def _spin(log: LicenceLog, row: int, limits: LicenceLimits) -> BrokenRule | None:
    spinning = log.airborne[:, row] & (np.abs(log.yaw_rate[:, row]) > limits.spin)
    tick = _first_lasting(spinning, round(limits.spun_s / float(log.t[0])))

    def what(tick: int) -> str:
        rate_deg = math.degrees(abs(float(log.yaw_rate[tick, row])))
        return f"{log.name(row)} spins at {rate_deg:.0f} deg/s"

    return _broken(log, row, "spin", tick, what)


def _yaw(log: LicenceLog, row: int, limits: LicenceLimits) -> BrokenRule | None:
    last = 0.0
    for one in log.of(row):
        if one.asked.yaw_rad == 0.0:  # most commands have none
            continue
        step, last = abs(one.asked.yaw_rad - last), one.asked.yaw_rad
        if abs(last) > 2.0 * math.pi and step > limits.yaw_step:
            what = f"{log.name(row)} is asked to turn to {one.asked.yaw_rad:.1f} rad"
            return BrokenRule("yaw", one.t, what, f"{one.words_without_time}, whose yaw is in radians")
    return None


def _command(log: LicenceLog, row: int, _: LicenceLimits) -> BrokenRule | None:
    for one in log.of(row):
        if one.asked.impossible:
            what = f"{log.name(row)} is asked for {one.asked.impossible}"
            return BrokenRule("command", one.t, what, one.words_without_time)
    return None


def _end(log: LicenceLog, row: int, _: LicenceLimits) -> BrokenRule | None:
    if not (log.airborne[-1, row] and log.running[-1, row]):
        return None
    t, end = float(log.t[-1]), log.end
    when = "at the time limit" if end.overdue else f"{t - end.t:.0f} s after the end of the program"
    what = f"{log.name(row)} still flies {when}"
    last = log.last(row, t)
    return BrokenRule("end", t, what, f"the last command was {last.words}" if last else "")


def _idle(log: LicenceLog, row: int, _: LicenceLimits) -> BrokenRule | None:
    if log.trial.kind != TrialKind.NOMINAL or log.flew[row]:
        return None
    asked = [one for one in log.of(row) if one.asked.kind in FLIGHT and one.asked.lifts]
    if asked:
        what = f"{log.name(row)} is asked to fly and stays on the floor"
        first = asked[0]
        why = f"{first.asked.refused}, {first.words}" if first.asked.refused else first.words
        return BrokenRule("idle", first.t, what, why)
    if row in log.opened and log.flew.any():
        t = float(log.t[_first(np.asarray(log.airborne.any(axis=1)))])
        return BrokenRule("idle", t, f"{log.name(row)} stays on the floor", "it was never asked to fly")
    return None


def _program(log: LicenceLog) -> BrokenRule | None:
    end, trial = log.end, log.trial
    rows = [row for row in range(len(log.uris)) if row != trial.excused]
    if end.unknown:
        why = f"{end.unknown} is one more than {len(log.uris)}"
        return BrokenRule("program", end.t, "the program opens more vehicles than there are", why)
    if trial.kind in EXCUSED:
        return None
    if end.overdue:
        return BrokenRule("program", end.t, "the program does not end", end.waits)
    if not end.status:
        return None
    tick = min(int(np.searchsorted(log.t, end.t)), len(log.t) - 1)
    safe = trial.kind != TrialKind.NOMINAL and not log.airborne[tick, rows].any()
    where = f", line {end.line}" if end.line else ""
    why = (end.error or f"exit status {end.status}") + where
    return None if safe else BrokenRule("program", end.t, "the program fails", why)


def _nearness(log: LicenceLog, limits: LicenceLimits) -> Iterator[BrokenRule | None]:
    for i, j in combinations(range(len(log.uris)), 2):
        apart = log.pos[:, i] - log.pos[:, j]
        flying = log.airborne[:, i] | log.airborne[:, j]
        tick = _first(np.asarray(flying & (np.linalg.norm(apart, axis=-1) < limits.gap)))
        if tick >= 0:
            t = float(log.t[tick])
            why = "; ".join(
                f"for {log.name(row)}, {failure_cause(log, row, t)}"
                for row in (i, j)
                if log.airborne[tick, row]
            )
            lost = log.trial.kind == TrialKind.LOST and log.trial.excused in {i, j}
            yield BrokenRule("collision", t, f"{log.name(i)} and {log.name(j)} collide", why, remark=lost)
        elif log.trial.kind == TrialKind.NOMINAL:
            yield _exposure(log, (i, j), apart, limits)


def _exposure(
    log: LicenceLog, pair: tuple[int, int], apart: Array, limits: LicenceLimits
) -> BrokenRule | None:
    i, j = pair
    scaled = apart / np.array([limits.beside, limits.beside, limits.below])
    inside = (np.linalg.norm(scaled, axis=-1) < 1.0) & log.airborne[:, i] & log.airborne[:, j]
    tick = _first_lasting(inside, round(limits.exposed_s / float(log.t[0])))
    if tick < 0:
        return None
    below, above = (i, j) if apart[tick, 2] < 0.0 else (j, i)
    t, depth = float(log.t[tick]), abs(float(apart[tick, 2]))
    what = f"{log.name(below)} flies in the downwash of {log.name(above)}, {depth:.2f} m below it"
    return BrokenRule("downwash", t, what, failure_cause(log, below, t))


RULES: tuple[Rule, ...] = (_motors, _landing, _room, _tumble, _setpoints, _spin, _yaw, _command, _end, _idle)
"""Rules of one vehicle."""
