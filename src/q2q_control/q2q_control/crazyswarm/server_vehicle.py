"""Remember what Crazyswarm2's server tells of one vehicle, and report it to the flight procedure.

The server tells parameters as they were when it connected, before it set those of crazyflies.yaml: what the
file sets counts. What was told more than TOLD_S ago is not known any more.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import inf, nan

from q2q_control.flight_procedure.observation import VehicleReport
from q2q_control.flight_procedure.supervisor_info import LOCKED, READY
from q2q_control.radio.firmware_params import difference
from q2q_model.vehicle.constants import Vehicle
from q2q_model.vehicle.hover_thrust import OWN_PARAMETERS, OwnHover, hover_ratio

TOLD_S = 3.0
"""The server logs a status once a second [s]."""
UNKNOWN = (nan, nan, nan)


class ServerVehicle:
    """What was last told of one vehicle."""

    def __init__(
        self, name: str, vehicle: Vehicle, wanted: Mapping[str, float], file: Mapping[str, float]
    ) -> None:
        """Remember a vehicle.

        Args:
            name: Its name.
            vehicle: What newtons are turned into PWM for.
            wanted: Parameters that it must hold.
            file: Parameters that crazyflies.yaml sets.
        """
        self.name = name
        self._vehicle, self._wanted, self._file = vehicle, wanted, file
        self._volt, self._info, self._status_at = nan, 0, -inf
        self._pos, self._pos_at = UNKNOWN, -inf
        self._held = dict(file)

    @property
    def read(self) -> tuple[str, ...]:
        """Return the names of the parameters that are worth asking for."""
        return (*self._wanted, *OWN_PARAMETERS)

    def take_status(self, volt: float, info: int, t: float) -> None:
        """Take battery [V] and `supervisor.info` at time t [s]."""
        self._volt, self._info, self._status_at = volt, info, t

    def take_estimate(self, pos: Sequence[float], t: float) -> None:
        """Take its own estimate x, y, z [m], world, at time t [s]; anything else is an estimate of NaN."""
        self._pos = (pos[0], pos[1], pos[2]) if len(pos) == 3 else UNKNOWN
        self._pos_at = t

    def take_parameters(self, told: Mapping[str, float]) -> None:
        """Take the parameters that the server knows; the file's count more."""
        self._held = {**told, **self._file}

    def armed_since(self, t: float) -> bool | None:
        """Return whether it has told to be armed since time t [s]; None where it has never told."""
        if self._status_at == -inf:
            return None
        return self._status_at > t and self._info & READY == READY

    def report(self, t: float, *, connected: bool) -> VehicleReport:
        """Return what is known at time t [s]."""
        silent = VehicleReport(
            self.name,
            connected=connected,
            wrong=difference(self._wanted, self._held) if self._held.keys() >= self._wanted.keys() else None,
            onboard=self._onboard(t),
            hover_ratio=self._hover_ratio(),
        )
        if t - self._status_at > TOLD_S:
            return silent
        return replace(
            silent,
            volt=self._volt,
            armed=self._info & READY == READY,
            locked=bool(self._info & LOCKED),
        )

    def _onboard(self, t: float) -> tuple[float, float, float] | None:
        """Return its own estimate [m]; NaN where it told once and does no more, None where it never did."""
        if self._pos_at == -inf:
            return None
        return self._pos if t - self._pos_at <= TOLD_S else UNKNOWN

    def _hover_ratio(self) -> float:
        if self._held.keys() >= set(OWN_PARAMETERS):
            return hover_ratio(self._vehicle, OwnHover(*(self._held[name] for name in OWN_PARAMETERS)))
        return nan
