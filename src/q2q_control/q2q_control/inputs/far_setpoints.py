"""Vehicles that are far from their setpoints: a plan began elsewhere, or they were carried off."""

from collections.abc import Mapping

import numpy as np

from q2q_model.counted import listed
from q2q_model.signals.values import (
    Array,
    Names,
    SwarmSetpoint,
    SwarmState,
    TrackStatus,
    index_of,
    rows_by_name,
)

FAR_M = 1.0
"""Distance from a setpoint that is reported [m]: no downwash or gust of a flight under control makes it."""

_ELSEWHERE = "far from their setpoints: {}: check that the plan begins where they fly"
_BROUGHT_DOWN = "far from their setpoints, brought down by the failsafe: {}"


def far_setpoints(state: SwarmState, setpoint: SwarmSetpoint, commanded: Names) -> dict[str, float]:
    """Return the distances from their setpoints [m] of the measured vehicles that are FAR_M away or more.

    Only of those that the controller commands: others may fly the rest.
    """
    aim = rows_by_name(setpoint.pos, setpoint.names, state.names, np.nan)
    aim[(state.status != TrackStatus.TRACKED) | (index_of(state.names, commanded) < 0)] = np.nan
    return far_apart(state.names, aim, state.pos)


def far_apart(names: Names, aim: Array, pos: Array) -> dict[str, float]:
    """Return the distances [m] between two positions (n, 3) of vehicles where they are FAR_M or more."""
    away = np.linalg.norm(aim - pos, axis=1)
    return {names[row]: float(away[row]) for row in np.flatnonzero(away >= FAR_M)}


def distances_text(away: Mapping[str, float]) -> str:
    """Return vehicles with their distances [m]: "cf1 1.2 m, cf2 3.0 m"."""
    return listed([f"{name} {distance:.1f} m" for name, distance in away.items()])


class FarSetpointMonitor:
    """Which vehicles are far from their setpoints, reported once for the same vehicles."""

    def __init__(self) -> None:
        self._reported: frozenset[str] = frozenset()
        self._brought_down: set[str] = set()  # by the failsafe, and not back since

    def update(
        self, state: SwarmState, setpoint: SwarmSetpoint, commanded: Names, brought_down: Names = ()
    ) -> tuple[str, bool]:
        """Return who is far from its setpoint, empty if nobody is, and whether these are new.

        Args:
            state: measured vehicles.
            setpoint: where they are to be.
            commanded: vehicles of the controller.
            brought_down: vehicles that the failsafe lands or cuts now.
        """
        far = far_setpoints(state, setpoint, commanded)
        self._brought_down = self._brought_down.intersection(far).union(brought_down)
        new, self._reported = not self._reported.issuperset(far), frozenset(far)
        return self._words(far), new

    def _words(self, far: dict[str, float]) -> str:
        """Return who is far, how far, and why."""
        found = []
        for is_down, words in ((False, _ELSEWHERE), (True, _BROUGHT_DOWN)):
            those = {name: away for name, away in far.items() if (name in self._brought_down) is is_down}
            if those:
                found.append(words.format(distances_text(those)))
        return "; ".join(found)
