"""Flights of a vehicle whose poses and references are where their times say."""

import numpy as np

from q2q_model.bag.foreign.pose_frames import Poses, pose_frames
from q2q_model.bag.foreign.references import References, with_references
from q2q_model.flights.flight import Flight
from q2q_model.flights.joined_flight import flight_from_signals
from q2q_model.signals.values import Array


def moving_poses(t: Array) -> Poses:
    """Return poses at some times, each where its time says."""
    return Poses(t, np.column_stack([t, t, t]), np.tile([0.0, 0.0, 0.0, 1.0], (len(t), 1)), 0.0)


def flown(poses: Array, references: Array, places: Array | None = None) -> tuple[Flight, list[str]]:
    """Return a flight with poses and references at some times, and remarks on the references.

    References are where their times say, or at `places` (T, 3).
    """
    frames, _ = pose_frames({"cf1": moving_poses(poses)}, 0.005)
    flight = flight_from_signals("made", {"mocap": frames}).flight
    pos = moving_poses(references).pos if places is None else places
    unknown = np.full((len(references), 3), np.nan)
    return with_references(flight, {"cf1": References(references, pos, unknown, unknown)})
