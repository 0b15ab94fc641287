"""Protocol of an air: what a simulated vehicle feels from the others, the ground and the wind.

A scenario, `fly --air`, the campaign and the simulator node accept a shipped name, a `.air` file or
`module:Class`. The class is made without arguments; its `reset` is called before a flight and its `push` at
each physics step (2 ms), so a wake that needs the past keeps it. Arrays that it receives never change later.
"""

from dataclasses import dataclass
from typing import NamedTuple, Protocol, runtime_checkable

from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import Vehicle


class Sources(NamedTuple):
    """Vehicles at one instant; each is a source of downwash and feels that of the others."""

    t: float
    """Time since the start of the flight [s]."""
    pos: Array
    """[m], world, z up, (n, 3)."""
    vel: Array
    """[m/s], world, (n, 3)."""
    quat: Array
    """Attitude xyzw, body to world, (n, 4)."""
    thrust: Array
    """Collective thrust [N], (n,)."""


class Push(NamedTuple):
    """Effect of the air on each vehicle."""

    acc: Array
    """Acceleration [m/s^2], world, (n, 3)."""
    torque: Array
    """Torque [N m], body, (n, 3)."""


@dataclass(frozen=True, slots=True)
class AirSetup:
    """Facts that a wake may need before a flight."""

    vehicle: Vehicle
    count: int
    """Number of vehicles."""
    step: float
    """Physics step [s]."""
    seed: int
    """Seed of the flight; a wake that draws uses q2q_sim.random_streams."""


@runtime_checkable
class Wake(Protocol):
    """Air of a flight."""

    def reset(self, setup: AirSetup) -> None:
        """Forget the past and prepare a flight."""

    def push(self, now: Sources) -> Push:
        """Return what every vehicle feels now, and advance the memory by one physics step."""
