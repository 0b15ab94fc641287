"""Signals of a run as arrays, one row per tick in the order in which they came, whatever their stamps."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from operator import attrgetter

import numpy as np
from numpy.typing import NDArray

from q2q_model.geometry.rotations import yaw_from_quat
from q2q_model.signals.layout import Signal
from q2q_model.signals.rows import stack_equal
from q2q_model.signals.values import (
    Array,
    Interference,
    Names,
    Status,
    SwarmCommand,
    SwarmSetpoint,
    SwarmState,
)
from q2q_model.vehicle.constants import GRAVITY


@dataclass(frozen=True, slots=True)
class RunTicks:
    """Flight of T ticks and n vehicles."""

    t: Array
    """True time [s], (T,)."""
    stamp: Array
    """Stamp of the command, which is that of the frame [s], (T,)."""
    names: Names
    truth: tuple[SwarmState, ...]
    states: tuple[SwarmState, ...]
    setpoints: tuple[SwarmSetpoint, ...]
    """After the replanner."""
    commands: tuple[SwarmCommand, ...]
    pushes: tuple[Interference, ...]
    """True downwash."""

    @property
    def command_status(self) -> Status:
        """Return the status of every command, (T, n)."""
        return over_ticks(self.commands, "status").astype(np.uint8)

    @property
    def newer(self) -> NDArray[np.bool_]:
        """Return which ticks have a stamp above all before, (T,)."""
        before = np.concatenate(([-np.inf], np.maximum.accumulate(self.stamp)[:-1]))
        return np.asarray(self.stamp > before)

    def commanded_acc(self) -> Array:
        """Return the horizontal acceleration that the commanded tilts ask for, world [m/s^2], (T, n, 2)."""
        roll, pitch = over_ticks(self.commands, "roll"), over_ticks(self.commands, "pitch")
        yaw = yaw_from_quat(over_ticks(self.truth, "quat"))
        ahead, aside = GRAVITY * np.tan(pitch), -GRAVITY * np.tan(roll)
        return np.stack(
            (np.cos(yaw) * ahead - np.sin(yaw) * aside, np.sin(yaw) * ahead + np.cos(yaw) * aside), axis=-1
        )


def over_ticks(signals: Sequence[Signal], attribute: str) -> Array:
    """Return one attribute of T signals of the same names, (T, n) or (T, n, width)."""
    return stack_equal(list(map(attrgetter(attribute), signals)))


def run_ticks(topics: Mapping[str, Sequence[Signal]]) -> RunTicks:
    """Return the ticks of a run from its signals by topic, as `closed_loop` makes them: one each per tick."""
    truth = tuple(one for one in topics["truth"] if isinstance(one, SwarmState))
    commands = tuple(one for one in topics["command"] if isinstance(one, SwarmCommand))
    return RunTicks(
        t=np.array([one.t for one in truth]),
        stamp=np.array([one.t for one in commands]),
        names=truth[0].names,
        truth=truth,
        states=tuple(one for one in topics["state"] if isinstance(one, SwarmState)),
        setpoints=tuple(one for one in topics["reference_safe"] if isinstance(one, SwarmSetpoint)),
        commands=commands,
        pushes=tuple(one for one in topics["truth_interference"] if isinstance(one, Interference)),
    )
