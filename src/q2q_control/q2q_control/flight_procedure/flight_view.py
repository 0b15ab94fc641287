"""Newest states, setpoints and plan of a flight, as one observation."""

import numpy as np

from q2q_control.flight_procedure.observation import Observation, PlanOutline, VehicleReport
from q2q_model.signals.values import (
    CUT,
    Array,
    Names,
    SwarmCommand,
    SwarmSetpoint,
    SwarmState,
    TrackStatus,
    index_of,
    rows_by_name,
)


class FlightView:
    """Newest state, setpoint and plan, one row per vehicle."""

    def __init__(self, names: Names) -> None:
        self._names = names
        n = len(names)
        self._pos, self._vel = np.full((n, 3), np.nan), np.full((n, 3), np.nan)
        self._seen = np.full(n, -np.inf)
        self._setpoint_pos, self._setpoint_vel = np.full((n, 3), np.nan), np.full((n, 3), np.nan)
        self._setpoint_at = -np.inf
        self._cut: Names = ()
        self._turned = np.ones(n, dtype=np.bool_)  # whose attitude is a number
        self.plan: PlanOutline | None = None
        """Plan that is waiting."""

    def store_state(self, state: SwarmState, t: float) -> None:
        """Store the vehicles measured in a state, received at time t [s]."""
        rows = index_of(self._names, state.names)
        for own, row in enumerate(rows.tolist()):
            if row >= 0 and state.status[row] == TrackStatus.TRACKED:
                self._pos[own], self._vel[own], self._seen[own] = state.pos[row], state.vel[row], t
                self._turned[own] = np.isfinite(state.quat[row]).all()

    def store_setpoint(self, setpoint: SwarmSetpoint, t: float) -> Array:
        """Store a setpoint received at time t [s]; return each vehicle's position, NaN if it has none."""
        self._setpoint_pos = rows_by_name(setpoint.pos, setpoint.names, self._names, np.nan)
        self._setpoint_vel = rows_by_name(setpoint.vel, setpoint.names, self._names, np.nan)
        self._setpoint_at = t
        return self._setpoint_pos

    def store_command(self, command: SwarmCommand) -> None:
        """Store which motors a command has cut."""
        cut = {command.names[row] for row in np.flatnonzero(command.status == CUT)}
        self._cut = tuple(name for name in self._names if name in cut)

    def observe(self, vehicles: tuple[VehicleReport, ...], t: float) -> Observation:
        """Return the observation at time t [s]."""
        return Observation(
            vehicles=vehicles,
            pos=self._pos.copy(),
            vel=self._vel.copy(),
            age=t - self._seen,
            setpoint_pos=self._setpoint_pos,
            setpoint_vel=self._setpoint_vel,
            setpoint_age=t - self._setpoint_at,
            plan=self.plan,
            cut=self._cut,
            without_attitude=tuple(self._names[row] for row in np.flatnonzero(~self._turned)),
        )
