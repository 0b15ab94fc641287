"""Vehicles that are far from their setpoints: a plan began elsewhere, or they were carried off."""

import numpy as np

from q2q_model.signals.values import SwarmSetpoint, SwarmState, TrackStatus, rows_by_name

FAR_M = 1.0
"""Distance from a setpoint that is told [m]: no downwash or gust of a flight under control makes it."""


def far_setpoints(state: SwarmState, setpoint: SwarmSetpoint) -> dict[str, float]:
    """Return the distances from their setpoints [m] of the measured vehicles that are FAR_M away or more."""
    aim = rows_by_name(setpoint.pos, setpoint.names, state.names, np.nan)
    away = np.linalg.norm(aim - state.pos, axis=1)
    far = (state.status == TrackStatus.TRACKED) & (away >= FAR_M)
    return {state.names[row]: float(away[row]) for row in np.flatnonzero(far)}


class FarSetpointMonitor:
    """Which vehicles are far from their setpoints, told once for the same vehicles."""

    def __init__(self) -> None:
        self._told: frozenset[str] = frozenset()

    def look(self, state: SwarmState, setpoint: SwarmSetpoint) -> tuple[str, bool]:
        """Return who is far from its setpoint, empty if nobody is, and whether these were not told before."""
        far = far_setpoints(state, setpoint)
        new, self._told = not self._told.issuperset(far), frozenset(far)
        if not far:
            return "", False
        places = ", ".join(f"{name} {away:.1f} m" for name, away in far.items())
        return f"far from their setpoints: {places}: does the plan begin where they fly?", new
