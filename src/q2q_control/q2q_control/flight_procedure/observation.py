"""Observation of a flight at one time: vehicle reports, positions, setpoints, the waiting plan."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from q2q_control.inputs.plan_samples import sampled_preview
from q2q_model.signals.values import Array, Names
from q2q_model.trajectory.polynomials import Trajectory


@dataclass(frozen=True, slots=True)
class VehicleReport:
    """Report of one vehicle; NaN or None for what it does not report."""

    name: str
    connected: bool
    volt: float = math.nan
    """Battery [V]."""
    armed: bool | None = None
    locked: bool | None = None
    """It is locked after an emergency stop and must be restarted."""
    flies: bool = True
    """It flies setpoints; False if it lands or has landed by itself."""
    airborne: bool | None = None
    """It flies, and does not land by itself."""
    cut: bool = False
    """Its motors were cut in this flight, by whomever."""
    silent_s: float = math.nan
    """Time since a setpoint or command was last sent to it [s]; NaN if its executor handles that itself."""
    wrong: str | None = None
    """First error of its parameters; empty if there is none."""
    onboard: tuple[float, float, float] | None = None
    """Onboard position estimate [m], world; NaN if it is no longer reported."""
    hover_ratio: float = math.nan
    """Thrust that would be sent at hover over the thrust at which it hovers."""


@dataclass(frozen=True, slots=True)
class PlanOutline:
    """Outline of a plan: first points, extent, duration."""

    names: Names
    first: Array
    """First point of every vehicle [m], world, (n, 3)."""
    low: Array
    """Minimum x, y, z of every vehicle [m], (n, 3)."""
    high: Array
    """Largest x, y, z of every vehicle [m], (n, 3)."""
    duration: float
    """[s]"""


def plan_outline(names: Names, trajectories: Sequence[Trajectory]) -> PlanOutline:
    """Return the outline of a plan, from samples every 10 ms."""
    pos = sampled_preview(names, trajectories, 0.0).samples[..., :3]  # (n, T, 3)
    duration = max(one.duration for one in trajectories)
    return PlanOutline(names, pos[:, 0], pos.min(axis=1), pos.max(axis=1), duration)


@dataclass(frozen=True, slots=True)
class Observation:
    """Observation of a flight at one time, one row per vehicle in the order of `vehicles`."""

    vehicles: tuple[VehicleReport, ...]
    pos: Array
    """Measured position [m], world, (n, 3); NaN before the first measurement."""
    vel: Array
    """[m/s], world, (n, 3)."""
    age: Array
    """Time since each vehicle was last measured [s], (n,); infinite before the first measurement."""
    setpoint_pos: Array
    """Setpoint position [m], world, (n, 3); NaN if there is none."""
    setpoint_vel: Array
    """Setpoint velocity [m/s], world, (n, 3)."""
    setpoint_age: float
    """Time since the last setpoint was received [s]; infinite before the first."""
    plan: PlanOutline | None
    """Plan that is waiting for its start."""
    cut: Names = ()
    """Vehicles whose motors the controller's last command has cut; in mode setpoint none."""
    without_attitude: Names = ()
    """Vehicles whose last measured state has no attitude to fly by."""

    @property
    def names(self) -> Names:
        """Return the names of the vehicles."""
        return tuple(one.name for one in self.vehicles)

    def first_points(self) -> Array:
        """Return the plan's first points in the order of the vehicles, (n, 3); NaN for one without a plan."""
        rows = np.full((len(self.vehicles), 3), np.nan)
        if self.plan is not None:
            for row, name in enumerate(self.names):
                if name in self.plan.names:
                    rows[row] = self.plan.first[self.plan.names.index(name)]
        return rows
