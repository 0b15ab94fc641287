"""Whether vehicles are at rest at their points."""

import numpy as np

from q2q_control.flight_procedure.checks.flight_checks import state_refusal
from q2q_control.flight_procedure.observation import Observation
from q2q_control.flight_procedure.procedure_params import FlightProcedureParams, LandingParams
from q2q_model.signals.values import Array


def at_height(
    observation: Observation,
    height: float,
    params: FlightProcedureParams,
    landing: LandingParams,
    near: float | None = None,
) -> str:
    """Return which vehicle is not at rest at a height [m]; empty if all are."""
    points = np.column_stack([observation.pos[:, :2], np.full(len(observation.names), height)])
    return at_points(observation, points, params, landing, near)


def at_points(
    observation: Observation,
    points: Array,
    params: FlightProcedureParams,
    landing: LandingParams,
    near: float | None = None,
) -> str:
    """Return which vehicle is not at rest within `near` (params.goal_tolerance) of its point (n, 3) [m]."""
    stale = state_refusal(observation, landing)
    if stale:
        return stale
    bound = params.goal_tolerance if near is None else near
    far = np.linalg.norm(observation.pos - points, axis=1).tolist()
    speed = np.linalg.norm(observation.vel, axis=1).tolist()
    for name, height, off, fast in zip(
        observation.names, observation.pos[:, 2].tolist(), far, speed, strict=True
    ):
        if not off <= bound:
            return f"{name} is at {height:z.2f} m, {off:.2f} m from where it should be"
        if not fast <= params.still_speed:
            return f"{name} still moves at {fast:.2f} m/s"
    return ""


def setpoints_rest(
    observation: Observation, params: FlightProcedureParams, points: Array | None = None
) -> bool:
    """Return whether setpoints are 100 times slower than a vehicle at rest, and at `points` (n, 3) [m]."""
    still = np.linalg.norm(observation.setpoint_vel, axis=1) < 0.01 * params.still_speed
    if points is None:
        return bool(still.all())
    near = np.linalg.norm(observation.setpoint_pos - points, axis=1) < 0.1 * params.goal_tolerance
    return bool(near.all() and still.all())


def heights_text(observation: Observation) -> str:
    """Return the height of every vehicle as text."""
    return ", ".join(
        f"{name} at {height:z.2f} m"
        for name, height in zip(observation.names, observation.pos[:, 2].tolist(), strict=True)
    )
