"""Filtered states of a flight recorded without them, from its motion capture.

The online filter is causal and depends on the frames alone, so it gives the states that a controller with
default filter parameters used, to the last bit.
"""

from dataclasses import replace

import numpy as np

from q2q_model.estimation.mocap_filter import MocapFilter
from q2q_model.estimation.mocap_filter_params import MocapFilterParams
from q2q_model.flights.flight import Flight
from q2q_model.signals.values import Mask, MocapFrame, SwarmState, TrackStatus


def with_filtered_states(flight: Flight) -> Flight:
    """Return the flight with filtered positions, velocities and attitudes, unchanged if it has any.

    A vehicle that the filter has lost is NaN.
    """
    if np.isfinite(flight.pos).any():
        return flight
    mocap_filter = MocapFilter(MocapFilterParams(), flight.names)
    states = [mocap_filter.update(mocap_frame(flight, tick)) for tick in range(flight.t.size)]
    tracked = np.stack([_known(state) for state in states])[..., None]  # (T, n, 1)
    pos, vel, quat = (
        np.where(tracked, np.stack(values), np.nan)
        for values in zip(*((one.pos, one.vel, one.quat) for one in states), strict=True)
    )
    return replace(flight, pos=pos, vel=vel, quat=quat)


def mocap_frame(flight: Flight, tick: int) -> MocapFrame:
    """Return the recorded frame of a tick, with the vehicles that it holds."""
    visible = np.nonzero(np.isfinite(flight.mocap_pos[tick]).all(axis=1))[0]
    return MocapFrame(
        t=float(flight.t[tick]),
        names=tuple(flight.names[row] for row in visible),
        pos=flight.mocap_pos[tick, visible],
        quat=flight.mocap_quat[tick, visible],
    )


def _known(state: SwarmState) -> Mask:
    return np.asarray(np.not_equal(state.status, TrackStatus.LOST))
