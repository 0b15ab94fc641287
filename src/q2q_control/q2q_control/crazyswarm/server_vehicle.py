"""One vehicle as reported by Crazyswarm2's server.

The server reports parameters as read when it connected, before it set those of crazyflies.yaml: the file's
values override them. A report older than STALE_S is stale.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import inf, nan

from q2q_control.flight_procedure.observation import VehicleReport
from q2q_control.flight_procedure.supervisor_info import FLYING, LOCKED, READY
from q2q_control.radio.link.firmware_params import (
    APP,
    CONTROLLER,
    OUT_OF_TREE,
    first_difference,
    required_with_app,
)
from q2q_model.vehicle.constants import Vehicle
from q2q_model.vehicle.hover_thrust import OWN_PARAMETERS, OwnHover, hover_ratio

STALE_S = 3.0
"""Age at which a report is stale [s]: the server logs a status once per second."""
UNKNOWN = (nan, nan, nan)


class ServerVehicle:
    """Newest report of one vehicle."""

    def __init__(
        self, name: str, vehicle: Vehicle, required: Mapping[str, float], file: Mapping[str, float]
    ) -> None:
        """Start without a report.

        Args:
            name: name of the vehicle.
            vehicle: constants that convert newtons to PWM.
            required: parameters that it must hold; for Mellinger's controller the firmware app's counts, too.
            file: parameters that crazyflies.yaml sets.
        """
        self.name = name
        self._vehicle, self._required, self._file = vehicle, required, file
        self._volt, self._info, self._status_at = nan, 0, -inf
        self._pos, self._pos_at = UNKNOWN, -inf
        self._sent_at = -inf
        self._held = dict(file)

    @property
    def read(self) -> tuple[str, ...]:
        """Return the names of the parameters to read from the server."""
        return (*self._required, *OWN_PARAMETERS)

    def take_status(self, volt: float, info: int, t: float) -> None:
        """Store battery [V] and `supervisor.info`, received at time t [s]."""
        self._volt, self._info, self._status_at = volt, info, t

    def take_estimate(self, pos: Sequence[float], t: float) -> None:
        """Store the onboard estimate x, y, z [m], world, received at time t [s]; another length gives NaN."""
        self._pos = (pos[0], pos[1], pos[2]) if len(pos) == 3 else UNKNOWN
        self._pos_at = t

    def take_sent(self, t: float) -> None:
        """Take note that a setpoint or command was sent at time t [s]."""
        self._sent_at = t

    def take_parameters(self, reported: Mapping[str, float]) -> None:
        """Store the parameters that the server reports; the file's override them."""
        self._held = {**reported, **self._file}

    def armed_since(self, t: float) -> bool | None:
        """Return whether a status since time t [s] says armed; None if there never was a status."""
        if self._status_at == -inf:
            return None
        return self._status_at > t and self._info & READY == READY

    def report(self, t: float, *, connected: bool) -> VehicleReport:
        """Return the report at time t [s]."""
        required, complete = self._required, self._held.keys() >= self._required.keys()
        if self._held.get(CONTROLLER) == OUT_OF_TREE:
            required = required_with_app(required, {APP})
        silent = VehicleReport(
            self.name,
            connected=connected,
            silent_s=t - self._sent_at,
            wrong=first_difference(required, self._held) if complete else None,
            onboard=self._onboard(t),
            hover_ratio=self._hover_ratio(),
        )
        if t - self._status_at > STALE_S:
            return silent
        return replace(
            silent,
            volt=self._volt,
            armed=self._info & READY == READY,
            locked=bool(self._info & LOCKED),
            airborne=bool(self._info & FLYING),
        )

    def _onboard(self, t: float) -> tuple[float, float, float] | None:
        """Return the onboard estimate [m]; NaN if it is stale, None if there never was one."""
        if self._pos_at == -inf:
            return None
        return self._pos if t - self._pos_at <= STALE_S else UNKNOWN

    def _hover_ratio(self) -> float:
        if self._held.keys() >= set(OWN_PARAMETERS):
            return hover_ratio(self._vehicle, OwnHover(*(self._held[name] for name in OWN_PARAMETERS)))
        return nan
