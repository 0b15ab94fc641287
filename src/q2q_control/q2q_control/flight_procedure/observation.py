"""Hold what is known of a flight at one time: vehicles, places, setpoints, the plan that waits."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from q2q_control.inputs.plan_samples import Curve, sampled_preview
from q2q_model.signals.values import Array, Names


@dataclass(frozen=True, slots=True)
class VehicleReport:
    """What one vehicle says of itself; NaN and None where it does not say."""

    name: str
    connected: bool
    volt: float = math.nan
    """Battery [V]."""
    armed: bool | None = None
    locked: bool | None = None
    """It has stopped for good and must be restarted."""
    flies: bool = True
    """It is flown by setpoints; False where it lands or has landed by itself."""
    wrong: str | None = None
    """What is wrong with its parameters; empty where nothing is."""
    onboard: tuple[float, float, float] | None = None
    """Position that it estimates itself [m], world; NaN where it has told it before."""
    hover_ratio: float = math.nan
    """Thrust that would be sent at hover over the thrust at which it hovers."""


@dataclass(frozen=True, slots=True)
class PlanOutline:
    """What the procedure needs to know of a plan."""

    names: Names
    first: Array
    """First point of every vehicle [m], world, (n, 3)."""
    low: Array
    """Least x, y, z of every vehicle [m], (n, 3)."""
    high: Array
    """Largest x, y, z of every vehicle [m], (n, 3)."""
    duration: float
    """[s]"""


def outline(names: Names, curves: Sequence[Curve]) -> PlanOutline:
    """Return the outline of a plan, from samples every 10 ms."""
    pos = sampled_preview(names, curves, 0.0).samples[..., :3]  # (n, T, 3)
    duration = max(float(curve.durations.sum()) for curve in curves)
    return PlanOutline(names, pos[:, 0], pos.min(axis=1), pos.max(axis=1), duration)


@dataclass(frozen=True, slots=True)
class Observation:
    """What is known at one time, a row a vehicle in the order of `vehicles`."""

    vehicles: tuple[VehicleReport, ...]
    pos: Array
    """Measured position [m], world, (n, 3); NaN where never seen."""
    vel: Array
    """[m/s], world, (n, 3)."""
    age: Array
    """Time since a vehicle was last measured [s], (n,); infinite where never."""
    wanted: Array
    """Setpoint's position [m], world, (n, 3); NaN where there is none."""
    wanted_vel: Array
    """[m/s], world, (n, 3)."""
    wanted_age: float
    """Time since the last setpoint came [s]; infinite where none came."""
    plan: PlanOutline | None
    """The plan that waits for its start."""

    @property
    def names(self) -> Names:
        """Return the names of the vehicles."""
        return tuple(one.name for one in self.vehicles)

    def first_points(self) -> Array:
        """Return the plan's first points in the order of the vehicles, (n, 3); NaN where it has none."""
        rows = np.full((len(self.vehicles), 3), np.nan)
        if self.plan is not None:
            for row, name in enumerate(self.names):
                if name in self.plan.names:
                    rows[row] = self.plan.first[self.plan.names.index(name)]
        return rows
