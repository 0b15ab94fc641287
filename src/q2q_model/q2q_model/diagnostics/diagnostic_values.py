"""Summary of a signal for `/diagnostics`, computed once per second outside the tick.

| signal | values |
|---|---|
| SwarmState | number of vehicles, coasting and lost ones, largest age, smallest separation |
| SwarmSetpoint | number of vehicles, shifted ones, broken promises, not finite ones, smallest separation |
| Interference | largest downwash, number of predictions with a stale source or without a model |
| SwarmCommand | number of saturated vehicles and of vehicles in fallback |
"""

from collections.abc import Mapping
from functools import singledispatch

import numpy as np

from q2q_model.diagnostics.smallest_separation import smallest_separation
from q2q_model.signals.layout import Signal
from q2q_model.signals.values import (
    CommandStatus,
    Interference,
    InterferenceStatus,
    Mask,
    SetpointStatus,
    SwarmCommand,
    SwarmSetpoint,
    SwarmState,
    TrackStatus,
)


@singledispatch
def diagnostic_values(signal: Signal) -> Mapping[str, str]:
    """Return the values of a signal by name; empty for other signals."""
    del signal
    return {}


@diagnostic_values.register
def _(signal: SwarmState) -> Mapping[str, str]:
    seen = signal.status != TrackStatus.LOST
    return {
        "vehicles": str(len(signal.names)),
        "coasting": _count(signal.status == TrackStatus.COASTING),
        "lost": _count(~seen),
        "age_max_s": _number(float(signal.age.max(initial=0.0))),
        "separation_m": _number(smallest_separation(signal.pos[seen])),
    }


@diagnostic_values.register
def _(signal: SwarmSetpoint) -> Mapping[str, str]:
    separation = smallest_separation(signal.pos)
    return {
        "vehicles": str(len(signal.names)),
        "separation_m": _number(separation),
        "shifted": _count(signal.status == SetpointStatus.SHIFTED),
        "promise_broken": _count(signal.status == SetpointStatus.PROMISE_BROKEN),
        "not_finite": _count(np.asarray(~np.isfinite(signal.pos).all(axis=1))),
    }


@diagnostic_values.register
def _(signal: Interference) -> Mapping[str, str]:
    largest = float(np.linalg.norm(signal.acc, axis=-1).max(initial=0.0))
    return {
        "downwash_max_m_s2": _number(largest),
        "stale_sources": _count(signal.status == InterferenceStatus.STALE_SOURCE),
        "no_model": _count(signal.status == InterferenceStatus.NO_MODEL),
    }


@diagnostic_values.register
def _(signal: SwarmCommand) -> Mapping[str, str]:
    return {
        "saturated": _count(signal.status == CommandStatus.SATURATED),
        "in_fallback": _count(signal.status >= CommandStatus.HOLD),
    }


def _count(which: Mask) -> str:
    return str(int(np.count_nonzero(which)))


def _number(value: float) -> str:
    return f"{value:.4g}"
