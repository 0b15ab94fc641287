"""Replay of a recorded flight next to its first draw in the air."""

from collections.abc import Sequence
from dataclasses import replace

from q2q_model.flights.flight import Flight
from q2q_model.signals.values import Array
from q2q_sim.experiments.validation.recorded.tracked_flight import TrackedFlight
from q2q_sim.experiments.validation.validated_flight import ValidatedFlight
from q2q_sim.loop.flight_recorder import FlightRecorder
from q2q_sim.replay_page import ReplayRun, replay_run


def replayed_runs(one: ValidatedFlight) -> list[ReplayRun]:
    """Return the recorded flight and its first draw, as their controllers saw them."""
    recorded, draw = one.flight, one.first
    return [
        replay_run(_flight(recorded, recorded.pos, recorded.quat, recorded.thrust), one.vehicle, "recorded"),
        replay_run(_flight(recorded, draw.pos[0], draw.quat[0], draw.thrust[0]), one.vehicle, "simulated"),
    ]


def longest_under_wake(flights: Sequence[ValidatedFlight]) -> ValidatedFlight:
    """Return the flight with most rows under a wake."""
    return max(flights, key=lambda one: sum(part.n for part in one.under))


def _flight(recorded: TrackedFlight, pos: Array, quat: Array, thrust: Array) -> Flight:
    empty = FlightRecorder(recorded.names, len(pos)).flight(recorded.name)
    return replace(empty, t=recorded.t, pos=pos, quat=quat, thrust=thrust, ref_pos=recorded.ref_pos)
