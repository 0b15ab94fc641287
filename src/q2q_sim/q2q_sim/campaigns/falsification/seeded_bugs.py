"""Seeded bugs: small mutants of gates, guard, replanner and recorder, by which a search is measured.

A seeded bug replaces one function while runs are flown. Each is of a kind that a change of this code could
bring in: a gate left open, an age not counted, a direction reversed, a report or a message left out.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from types import ModuleType
from weakref import WeakKeyDictionary

import numpy as np

from q2q_control.failsafe import guard
from q2q_control.failsafe.evasion import descent_evasion
from q2q_control.failsafe.evasion.descent_evasion import DescentEvasion
from q2q_control.failsafe.evasion.evasion_direction import evasion_direction
from q2q_control.failsafe.guard import Guard
from q2q_control.failsafe.tracking_loss import dead_reckoned_braking
from q2q_control.failsafe.tracking_loss.braking_law import ReckonedMotions, braking_tilt
from q2q_control.failsafe.tracking_loss.dead_reckoned_braking import DeadReckonedBraking
from q2q_model.bag import BagWriter
from q2q_model.estimation import mocap_filter
from q2q_model.estimation.association.label_swaps import swapped_sources
from q2q_model.estimation.association.reacquisition import Reacquisition
from q2q_model.estimation.association.suspected_swaps import LastSample, Unmatched
from q2q_model.estimation.mocap_filter_params import MocapFilterParams, track_params
from q2q_model.estimation.position import position_tracks
from q2q_model.estimation.position.position_tracks import PositionTracks
from q2q_model.estimation.position.track_columns import TrackParams
from q2q_model.estimation.position.track_update import TrackUpdate
from q2q_model.signals.clock_resets import ClockResetDetector
from q2q_model.signals.layout import Signal
from q2q_model.signals.values import (
    Array,
    CommandStatus,
    Mask,
    MocapFrame,
    Rows,
    SwarmCommand,
    SwarmSetpoint,
    SwarmState,
)
from q2q_planner.online.safe import safe_replanner
from q2q_planner.online.safe.choice import motion_choice
from q2q_planner.online.safe.choice.motion_choice import NEW, Choices
from q2q_planner.online.safe.motion.committed_motion import CommittedMotion
from q2q_planner.online.safe.motion.motion_propagation import propagate
from q2q_planner.online.safe.motion.safe_replanner_params import SafeReplannerParams
from q2q_planner.online.safe.motion.traffic import TrafficTable
from q2q_planner.online.safe.stopping.braking import BrakingLaw

# ruff: noqa: SLF001  a mutant replaces what nobody else may touch
_associated, _with_fallback = PositionTracks.associated, Guard._with_fallback
_output = safe_replanner._output
_write_signal = BagWriter.write_signal


@dataclass(frozen=True, slots=True)
class SeededBug:
    """One mutant."""

    name: str
    place: type | ModuleType
    """Module or class whose function is replaced."""
    function: str
    wrong: Callable[..., object]
    """Replacement."""

    @contextmanager
    def seeded(self) -> Iterator[None]:
        """Replace the function for the duration of a block."""
        sound = vars(self.place)[self.function]
        setattr(self.place, self.function, self.wrong)
        try:
            yield
        finally:
            setattr(self.place, self.function, sound)


def _open_gate(params: MocapFilterParams) -> TrackParams:
    return track_params(replace(params, jump_max=10.0 * params.jump_max))


def _long_coast(params: MocapFilterParams) -> TrackParams:
    return track_params(replace(params, coast_s=10.0 * params.coast_s))


def _never_ambiguous(_: Reacquisition, __: float, pos: Array, ___: LastSample, ____: Unmatched) -> Mask:
    return np.zeros(len(pos), np.bool_)


def _repeats_accepted(self: PositionTracks, t: float, samples: Array, repeats: Mask) -> TrackUpdate:
    return _associated(self, t, samples, np.zeros_like(repeats))


def _swap_without_gate(measured: Array, expected: Array, gate: Array, rejected: Mask, missing: Mask) -> Rows:
    return swapped_sources(measured, expected, 100.0 * gate, rejected, missing)


def _clock_never_reset(_: ClockResetDetector, __: float) -> bool:
    return False


def _age_always_zero(self: PositionTracks, _: float) -> Array:
    return np.where(self._tracks.seen, 0.0, np.inf)


def _degraded_unreported(self: Guard, command: SwarmCommand, state_age: Array) -> SwarmCommand:
    found = _with_fallback(self, command, state_age)
    status = np.where(found.status == CommandStatus.DEGRADED, CommandStatus.OK, found.status)
    return replace(found, status=status.astype(np.uint8))


def _held_unreported(last: SwarmCommand, t: float) -> SwarmCommand:
    return replace(last, t=t)


def _ages_unshifted(self: Guard, last: SwarmCommand, t: float) -> None:
    self._last = replace(last, t=t)


def _no_braking(_: DeadReckonedBraking, __: SwarmState | None, command: SwarmCommand) -> SwarmCommand:
    return command


def _braking_reversed(motions: ReckonedMotions) -> tuple[Array, Array]:
    roll, pitch = braking_tilt(motions)
    return -roll, -pitch


def _no_evasion(_: DescentEvasion, setpoint: SwarmSetpoint, *__: object) -> SwarmSetpoint:
    return setpoint


def _evasion_reversed(xy: Array, pair: tuple[int, int], rest: Array, reach: float) -> Array:
    return -evasion_direction(xy, pair, rest, reach)


def _no_proof(_: CommittedMotion, traffic: TrafficTable, *__: object) -> Choices:
    return np.full(traffic.own, NEW, np.int8)


def _hold_forgotten(
    committed: CommittedMotion | None, setpoint: SwarmSetpoint, params: SafeReplannerParams
) -> CommittedMotion:
    moved = propagate(committed, setpoint, params)
    if committed is None or len(committed.names) != len(moved.names):
        return moved
    return moved.with_rows(moved.rows._replace(hold=committed.rows.hold))


def _half_zone(eps: float, d: float, brake: float, jerk: float) -> BrakingLaw:
    return BrakingLaw(eps, 0.5 * d, brake, jerk)


def _break_unreported(
    setpoint: SwarmSetpoint, committed: CommittedMotion, broken: Mask, acc: Array
) -> SwarmSetpoint:
    return _output(setpoint, committed, np.zeros_like(broken), acc)


_newest: WeakKeyDictionary[BagWriter, dict[str, float]] = WeakKeyDictionary()


def _old_stamps_dropped(self: BagWriter, topic: str, stamp_ns: int, signal: Signal) -> None:
    newest = _newest.setdefault(self, {})
    if signal.t >= newest.get(topic, -np.inf):
        newest[topic] = signal.t
        _write_signal(self, topic, stamp_ns, signal)


def _nan_as_zero(self: BagWriter, topic: str, stamp_ns: int, signal: Signal) -> None:
    if isinstance(signal, MocapFrame):
        signal = replace(signal, pos=np.nan_to_num(signal.pos))
    _write_signal(self, topic, stamp_ns, signal)


SEEDED_BUGS: Sequence[SeededBug] = (
    SeededBug("open_gate", mocap_filter, "track_params", _open_gate),
    SeededBug("long_coast", mocap_filter, "track_params", _long_coast),
    SeededBug("never_ambiguous", Reacquisition, "update_ambiguous", _never_ambiguous),
    SeededBug("repeats_accepted", PositionTracks, "associated", _repeats_accepted),
    SeededBug("swap_without_gate", position_tracks, "swapped_sources", _swap_without_gate),
    SeededBug("clock_never_reset", ClockResetDetector, "confirm_reset", _clock_never_reset),
    SeededBug("age_always_zero", PositionTracks, "age", _age_always_zero),
    SeededBug("degraded_unreported", Guard, "_with_fallback", _degraded_unreported),
    SeededBug("held_unreported", guard, "repeated_command", _held_unreported),
    SeededBug("ages_unshifted", Guard, "_set_back", _ages_unshifted),
    SeededBug("no_braking", DeadReckonedBraking, "update", _no_braking),
    SeededBug("braking_reversed", dead_reckoned_braking, "braking_tilt", _braking_reversed),
    SeededBug("no_evasion", DescentEvasion, "update", _no_evasion),
    SeededBug("evasion_reversed", descent_evasion, "evasion_direction", _evasion_reversed),
    SeededBug("no_proof", safe_replanner, "_choice", _no_proof),
    SeededBug("hold_forgotten", safe_replanner, "propagate", _hold_forgotten),
    SeededBug("half_zone", motion_choice, "BrakingLaw", _half_zone),
    SeededBug("break_unreported", safe_replanner, "_output", _break_unreported),
    SeededBug("old_stamps_dropped", BagWriter, "write_signal", _old_stamps_dropped),
    SeededBug("nan_as_zero", BagWriter, "write_signal", _nan_as_zero),
)
