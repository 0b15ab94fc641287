"""What vehicles refuse of their CRTP clients: packets, and clients beyond the largest number."""

from collections.abc import Sequence
from typing import NamedTuple

from q2q_sim.crtp.vehicle import MOST_CLIENTS, CrtpVehicle


class _Counts(NamedTuple):
    """Counts of a vehicle since its start."""

    refused: int = 0
    displaced: int = 0


class ClientWarnings:
    """Refusals of a fleet since the last poll."""

    def __init__(self, vehicles: Sequence[CrtpVehicle]) -> None:
        self._vehicles = vehicles
        self._reported = [_Counts()] * len(vehicles)

    def poll(self) -> str:
        """Return what each vehicle has refused since the last call, and why; empty if nothing."""
        before = self._reported
        self._reported = [_Counts(one.refusals.count, one.displaced) for one in self._vehicles]
        reports = map(_refusals, self._vehicles, before, self._reported)
        return "; ".join(one for one in reports if one)


def _refusals(vehicle: CrtpVehicle, before: _Counts, now: _Counts) -> str:
    refused, displaced = now.refused - before.refused, now.displaced - before.displaced
    found = [f"packets refused: {refused} ({vehicle.refusals.last})"] if refused else []
    if displaced:
        found.append(f"clients displaced: {displaced} (at most {MOST_CLIENTS}: stop the others)")
    return f"CRTP of {vehicle.name}: {', '.join(found)}" if found else ""
