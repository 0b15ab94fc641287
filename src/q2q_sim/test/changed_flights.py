"""A recorded flight whose signals are changed, for tests of policies."""

from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import cache

import numpy as np

from q2q_model.model_files.find_model import find_model
from q2q_model.signals.some_vehicles import of_vehicles
from q2q_model.signals.values import SwarmCommand
from q2q_sim.link.radio import RadioParams
from q2q_sim.loop.closed_loop import FlightOptions, fly
from q2q_sim.monitors.policies import (
    Circumstances,
    RecordedSignal,
    judge,
    trace_of,
)
from q2q_sim.scenarios import library
from q2q_sim.sensors.vicon_params import ViconParams

SCENARIO = replace(library.load("stack3"), duration=8.0, vicon=ViconParams(), radio=RadioParams())
AROUND = Circumstances(vehicle=SCENARIO.vehicle)
Change = Callable[[RecordedSignal], RecordedSignal]


@cache
def received() -> tuple[RecordedSignal, ...]:
    """Return what a flight of three vehicles without faults says."""
    found: list[RecordedSignal] = []
    options = FlightOptions(
        model=find_model(SCENARIO.model).interaction,
        on_signal=lambda topic, stamp_ns, signal: found.append(
            RecordedSignal(topic, stamp_ns * 1e-9, signal)
        ),
    )
    fly(SCENARIO, options)
    return tuple(found)


def broken(change: Change, around: Circumstances = AROUND) -> set[str]:
    """Return the policies that the flight breaks with a change of its signals."""
    return {one.policy for one in judge(trace_of(map(change, received())), around)}


def changed(kind: type, since: float, until: float, **columns: Callable[[np.ndarray], np.ndarray]) -> Change:
    """Return a change of signals of a kind from a time to another."""

    def change(one: RecordedSignal) -> RecordedSignal:
        if not isinstance(one.signal, kind) or not since <= one.signal.t < until:
            return one
        new = {key: edit(getattr(one.signal, key).copy()) for key, edit in columns.items()}
        return replace(one, signal=replace(one.signal, **new))

    return change


def one_each(recorded: Iterable[RecordedSignal]) -> list[RecordedSignal]:
    """Return a flight whose commands come in one message for each vehicle, as of distributed controllers."""
    return [part for one in recorded for part in _parts(one)]


def _parts(one: RecordedSignal) -> list[RecordedSignal]:
    whole = one.signal
    if not isinstance(whole, SwarmCommand):
        return [one]
    return [replace(one, signal=of_vehicles(whole, np.array([k]))) for k in range(len(whole.names))]


def only(topic: str, change: Change) -> Change:
    """Return a change of the signals of one topic."""
    return lambda one: change(one) if one.topic == topic else one


def with_row(row: int, value: float | np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
    """Return an edit that puts a value in a row."""

    def edit(column: np.ndarray) -> np.ndarray:
        column[row] = value
        return column

    return edit
