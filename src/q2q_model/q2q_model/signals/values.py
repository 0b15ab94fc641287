"""Signals between blocks: one dataclass per topic and bag channel.

Every signal of a tick carries the capture time `t` [s] of its mocap frame. Arrays have one row per vehicle,
in the order of `names`. World frame, z up; quaternions x y z w, body to world.
"""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum
from functools import lru_cache
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Status = NDArray[np.uint8]
Mask = NDArray[np.bool_]
Rows = NDArray[np.intp]
Names = tuple[str, ...]
Three = tuple[float, float, float]
Four = tuple[float, float, float, float]
Value = TypeVar("Value", np.float64, np.uint8, np.int8, np.bool_)
"""Of an array with a row for each vehicle."""

KNOWN_NAMES = 64
"""Pairs of name lists whose rows are remembered: those of a flight's signals seldom change."""


class TrackStatus(IntEnum):
    """Quality of a vehicle's state (SwarmState.status)."""

    TRACKED = 0
    COASTING = 1
    LOST = 2


class SetpointStatus(IntEnum):
    """Relation of a setpoint to the plan (SwarmSetpoint.status)."""

    NOMINAL = 0
    SHIFTED = 1
    PROMISE_BROKEN = 2


class InterferenceStatus(IntEnum):
    """Confidence in a predicted downwash (Interference.status)."""

    VALID = 0
    STALE_SOURCE = 1
    NO_MODEL = 2


class CommandStatus(IntEnum):
    """Origin of a command (SwarmCommand.status)."""

    OK = 0
    SATURATED = 1
    HOLD = 2
    LEVEL = 3
    DEGRADED = 4
    LAND = 5
    CUT = 6


TRACKED, LOST = int(TrackStatus.TRACKED), int(TrackStatus.LOST)
SHIFTED, PROMISE_BROKEN = int(SetpointStatus.SHIFTED), int(SetpointStatus.PROMISE_BROKEN)
VALID, STALE_SOURCE = int(InterferenceStatus.VALID), int(InterferenceStatus.STALE_SOURCE)
NO_MODEL = int(InterferenceStatus.NO_MODEL)
OK, SATURATED = int(CommandStatus.OK), int(CommandStatus.SATURATED)
HOLD, LEVEL, LAND = int(CommandStatus.HOLD), int(CommandStatus.LEVEL), int(CommandStatus.LAND)
CUT = int(CommandStatus.CUT)
"""The same as plain integers, for every tick: numpy takes 5 us to read an enumeration."""


@dataclass(frozen=True, slots=True)
class MocapFrame:
    """Frame of motion capture: any subset of the vehicles, in any order."""

    t: float
    names: Names
    pos: Array
    """Position [m], world, (n, 3)."""
    quat: Array
    """Orientation x y z w, body to world, (n, 4); NaN where only a marker is tracked."""


@dataclass(frozen=True, slots=True)
class SwarmState:
    """State of every vehicle: filtered, or the simulator's true state on `truth`."""

    t: float
    names: Names
    pos: Array
    """Position [m], world, (n, 3)."""
    vel: Array
    """Velocity [m/s], world, (n, 3)."""
    quat: Array
    """Orientation x y z w, body to world, (n, 4); level, at rest, where none was ever measured; NaN where all
    were upside down."""
    ang_vel_body: Array
    """Angular velocity [rad/s], body, (n, 3)."""
    age: Array
    """Time since the last accepted measurement [s], (n,)."""
    status: Status
    """TrackStatus, (n,)."""


@dataclass(frozen=True, slots=True)
class SwarmSetpoint:
    """Setpoints of all vehicles at the tick."""

    t: float
    names: Names
    pos: Array
    """Position [m], world, (n, 3)."""
    vel: Array
    """Velocity [m/s], world, (n, 3)."""
    acc: Array
    """Acceleration [m/s^2], world, (n, 3)."""
    yaw: Array
    """Yaw [rad], (n,)."""
    yaw_rate: Array
    """Yaw rate [rad/s], (n,)."""
    status: Status
    """SetpointStatus, (n,)."""


@dataclass(frozen=True, slots=True)
class Interference:
    """Acceleration of every vehicle due to the downwash of its neighbours: eta of eq. (14)."""

    t: float
    names: Names
    acc: Array
    """eta [m/s^2], world, (n, 3)."""
    std: Array
    """One standard deviation of the prediction [m/s^2], (n, 3); NaN where unknown."""
    status: Status
    """InterferenceStatus, (n,)."""


@dataclass(frozen=True, slots=True)
class SwarmCommand:
    """Commands to the onboard attitude controllers."""

    t: float
    names: Names
    thrust: Array
    """Collective thrust U1 [N], along body z, (n,)."""
    roll: Array
    """phi [rad], (n,)."""
    pitch: Array
    """theta [rad], (n,)."""
    yaw_rate: Array
    """Yaw rate [rad/s], about body z, (n,)."""
    status: Status
    """CommandStatus, (n,)."""


@dataclass(frozen=True, slots=True)
class SwarmImu:
    """Readings of the vehicles' inertial sensors."""

    t: float
    names: Names
    specific_force_body: Array
    """Acceleration minus gravity [m/s^2], body, (n, 3)."""
    ang_vel_body: Array
    """Angular velocity [rad/s], body, (n, 3)."""


def check_unique(names: Sequence[str]) -> None:
    """Raise ValueError if a name is given twice."""
    if len(set(names)) < len(names):
        raise ValueError(f"duplicate vehicle names in {', '.join(names)}; names must be unique")


def given_twice(names: Iterable[str]) -> set[str]:
    """Return the names that are given more than once."""
    return {name for name, times in Counter(names).items() if times > 1}


def index_of(names: Sequence[str], among: Sequence[str]) -> Rows:
    """Return a new array of the row in `among` of each of `names`; -1 where it is absent, (len(names),)."""
    return _index_of(tuple(names), tuple(among)).copy()


def rows_by_name(
    values: NDArray[Value], have: Names, names: Names, missing: float | NDArray[Value] = 0.0
) -> NDArray[Value]:
    """Return the rows of `names` of values (m, ...), whose rows are `have`, (len(names), ...).

    A name that is not among them gets `missing`: a number, a row, or its row of an array for all names.
    """
    if names == have:
        return values.copy()
    rows = index_of(names, have)
    found = np.empty((len(rows), *values.shape[1:]), dtype=values.dtype)
    found[:] = missing
    found[rows >= 0] = values[rows[rows >= 0]]
    return found


def predicted_eta(interference: Interference | None, names: Names) -> Array:
    """Return the predicted downwash of vehicles [m/s^2], world, (n, 3); 0 where none is predicted."""
    if interference is None:
        return np.zeros((len(names), 3))
    return rows_by_name(interference.acc, interference.names, names)


@lru_cache(maxsize=KNOWN_NAMES)
def _index_of(names: Names, among: Names) -> Rows:
    if names == among:
        return np.arange(len(names))
    rows = _rows_of(among)
    return np.array([rows.get(name, -1) for name in names], dtype=np.intp)


@lru_cache(maxsize=KNOWN_NAMES)
def _rows_of(names: Names) -> Mapping[str, int]:
    return {name: row for row, name in enumerate(names)}
