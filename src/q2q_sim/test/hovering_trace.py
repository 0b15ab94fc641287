"""A flight of vehicles that hover exactly at their setpoints, for tests of policies that change it."""

import numpy as np

from q2q_model.signals.values import Array, CommandStatus, TrackStatus
from q2q_sim.monitors.policies import FlightTrace

TICK = 0.01


def hovering(places: Array, ticks: int = 100) -> FlightTrace:
    """Return `ticks` of vehicles cf1, ... that hover at places (n, 3) [m], world."""
    n = len(places)
    zero = np.zeros((ticks, n))
    true_pos, sent_pos, asked_pos, state_pos = (np.tile(places, (ticks, 1, 1)) for _ in range(4))
    return FlightTrace(
        t=TICK * np.arange(ticks),
        names=tuple(f"cf{k + 1}" for k in range(n)),
        true_pos=true_pos,
        sent_pos=sent_pos,
        asked_pos=asked_pos,
        seen=np.ones((ticks, n), np.bool_),
        state_pos=state_pos,
        state_age=zero.copy(),
        state_status=np.full((ticks, n), float(TrackStatus.TRACKED)),
        thrust=zero + 0.3,
        roll=zero.copy(),
        pitch=zero.copy(),
        command_status=np.full((ticks, n), float(CommandStatus.OK)),
        recorded_at=np.zeros(0),
        commanded_at={},
        live=False,
        not_finite=(),
    )
