"""Scene of a flight from its signals, in plain shapes for any viewer.

| group | shape | meaning |
|---|---|---|
| vehicle | box | pose; grey while coasting, dark when lost |
| name | text | name, above the vehicle |
| zone | cylinder | I(eps, d) about the vehicle; vermillion while another vehicle is in it |
| wake | line | air that left the rotors: r(t - tau) - b(t - tau) w tau, b body z, w its speed |
| force | arrow | eta, `force_scale` metres for each m/s^2 |
| plan | line | planned path; the recent reference without a plan |
| replanned | line | output of the replanner in the last `trail_s` |
| flown | line | path of the vehicle in the last `trail_s` |

A force or setpoint is drawn up to STALE_S after its stamp; a vehicle of unknown attitude is drawn level.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import ceil

import numpy as np
from numpy.typing import NDArray

from q2q_model import palette
from q2q_model.geometry.rotations import UP, level_where_unknown, rotate
from q2q_model.geometry.zone import Cylinder
from q2q_model.signals.layout import Signal
from q2q_model.signals.values import (
    Array,
    Interference,
    SwarmSetpoint,
    SwarmState,
    Three,
    TrackStatus,
)
from q2q_model.trajectory.polynomials import SwarmPlan
from q2q_model.tunable import check_bounds, tunable
from q2q_sim.air.wake_laws import MEASURED_SPEED
from q2q_sim.view.shapes import Colour, Scene, Shape, ShapeKind
from q2q_sim.view.trails import AirTrail, Trail, point_of

COLOURS: tuple[Colour, ...] = tuple(palette.rgba(colour) for colour in palette.VEHICLES)
"""One for each vehicle, repeated."""
COASTING: Colour = (0.6, 0.6, 0.6, 1.0)
LOST: Colour = (0.2, 0.2, 0.2, 1.0)
CLEAR: Colour = palette.rgba(palette.GREY, 0.12)
BREACHED: Colour = palette.rgba(palette.PUSH, 0.3)
AIR: Colour = palette.rgba(palette.AIR, 0.8)
FORCE: Colour = palette.rgba(palette.PUSH)
TEXT: Colour = palette.rgba(palette.BLACK)
REPLANNED: Colour = palette.rgba(palette.BLACK)

BODY: Three = (0.092, 0.092, 0.029)
"""A Crazyflie's motor diagonal and height [m] (Bitcraze)."""
TEXT_HEIGHT = 0.08
"""[m]"""
TEXT_ABOVE = 0.12
"""Height of the name above the vehicle [m]."""
FORCE_SHOWN = 0.01
"""Smallest downwash that is drawn [m/s^2]: a thousandth of g."""
STALE_S = 0.5
"""Difference from the stamp of the state beyond which a signal is not drawn [s]: fifty ticks."""
PLAN_STEP = 0.1
"""Time between points of a planned path [s], if that is no more than MOST_STEPS."""
ROUNDING = 1e-6
MOST_STEPS = 3000
"""Most parts of a planned path: five minutes in full."""
THIN, THICK = 0.008, 0.02
"""Widths of lines and arrows [m]."""


@dataclass(frozen=True, slots=True)
class SceneParams:
    """Parameters of the drawing."""

    eps: float = tunable(Cylinder().eps, "radius of the zones drawn", unit="m", low=0.01, high=10.0)
    d: float = tunable(Cylinder().d, "half height of the zones drawn", unit="m", low=0.01, high=10.0)
    wake_speed: float = tunable(
        MEASURED_SPEED, "speed at which the drawn downwash travels", unit="m/s", low=0.1, high=100.0
    )
    force_scale: float = tunable(
        0.3, "length of the arrow of a downwash of 1 m/s^2", unit="m", low=0.0, high=10.0
    )
    trail_s: float = tunable(10.0, "time that the vehicles' trails cover", unit="s", low=0.1, high=600.0)
    trail_hz: float = tunable(20.0, "number of points of a trail per second", unit="Hz", low=0.1, high=100.0)

    def __post_init__(self) -> None:
        """Check the bounds."""
        check_bounds(self)


@dataclass(frozen=True, slots=True)
class SceneSignals:
    """Signals at one time; missing ones are not drawn."""

    state: SwarmState
    interference: Interference | None = None
    reference: SwarmSetpoint | None = None
    reference_safe: SwarmSetpoint | None = None


def scene_signals(state: SwarmState, last: Mapping[str, Signal]) -> SceneSignals:
    """Return the last signal of each kind with a state, unless their stamps differ by more than STALE_S."""
    recent = {topic: one for topic, one in last.items() if abs(state.t - one.t) <= STALE_S}
    downwash, planned, safe = map(recent.get, ("interference", "reference", "reference_safe"))
    return SceneSignals(
        state,
        downwash if isinstance(downwash, Interference) else None,
        planned if isinstance(planned, SwarmSetpoint) else None,
        safe if isinstance(safe, SwarmSetpoint) else None,
    )


class SceneBuilder:
    """Builder of scenes, with the memory of paths and air."""

    def __init__(self, params: SceneParams) -> None:
        """Take the parameters of the drawing."""
        self._params = params
        self._plans: dict[str, tuple[Three, ...]] = {}
        self._air: dict[str, AirTrail] = {}
        self._trails: dict[tuple[str, str], Trail] = {}

    def take_plan(self, plan: SwarmPlan) -> None:
        """Set the plan to draw, in place of the one before."""
        self._plans.clear()
        for name, curve in zip(plan.names, plan.trajectories, strict=True):
            steps = ceil(min(curve.duration / PLAN_STEP - ROUNDING, MOST_STEPS))
            times = np.linspace(0.0, curve.duration, steps + 1)
            self._plans[name] = tuple(point_of(row) for row in curve.at(times)[:, :3])

    def update(self, seen: SceneSignals) -> Scene:
        """Return the scene at the time of `seen.state`; call in order of time."""
        state = replace(seen.state, quat=level_where_unknown(seen.state.quat))
        seen = replace(seen, state=state)
        known = [row for row in range(len(state.names)) if np.isfinite(state.pos[row]).all()]
        shapes = [
            *(shape for row in known for shape in self._vehicle(state, row)),
            *self._zones(state, known),
            *(shape for row in known for shape in self._forces(seen, row)),
            *self._paths(seen, known),
        ]
        return Scene(state.t, state.names, tuple(shapes))

    def _vehicle(self, state: SwarmState, row: int) -> list[Shape]:
        where, name = point_of(state.pos[row]), state.names[row]
        x, y, z, w = state.quat[row].tolist()
        above = (where[0], where[1], where[2] + TEXT_ABOVE)
        colour = _colour(row, int(state.status[row]))
        size = (0.0, 0.0, TEXT_HEIGHT)
        return [
            Shape(ShapeKind.BOX, "vehicle", row, colour, (where,), BODY, (x, y, z, w)),
            Shape(ShapeKind.TEXT, "name", row, TEXT, (above,), size, text=name),
            Shape(ShapeKind.LINE, "wake", row, AIR, self._blown(state, row), (THICK, 0.0, 0.0)),
        ]

    def _blown(self, state: SwarmState, row: int) -> tuple[Three, ...]:
        air = self._air.setdefault(state.names[row], AirTrail())
        axis = rotate(state.quat[row], UP)
        air.add(state.t, state.pos[row], axis, self._params.d / self._params.wake_speed)
        return air.at(state.t, self._params.wake_speed)

    def _zones(self, state: SwarmState, known: list[int]) -> list[Shape]:
        zone = Cylinder(self._params.eps, self._params.d)
        inside = zones_breached(state.pos[known], zone)
        size = (2.0 * zone.eps, 2.0 * zone.eps, 2.0 * zone.d)
        return [
            Shape(
                ShapeKind.CYLINDER, "zone", row, BREACHED if bad else CLEAR, (point_of(state.pos[row]),), size
            )
            for row, bad in zip(known, inside.tolist(), strict=True)
        ]

    def _forces(self, seen: SceneSignals, row: int) -> list[Shape]:
        eta = _own(seen.interference, seen.state.names[row])
        if eta is None or not np.linalg.norm(eta) >= FORCE_SHOWN:
            return []
        tail = seen.state.pos[row]
        ends = (point_of(tail), point_of(tail + self._params.force_scale * eta))
        return [Shape(ShapeKind.ARROW, "force", row, FORCE, ends, (THICK, 0.0, 0.0))]

    def _paths(self, seen: SceneSignals, known: list[int]) -> list[Shape]:
        made = []
        for row in known:
            name, own = seen.state.names[row], COLOURS[row % len(COLOURS)]
            planned = self._trail("plan", name, seen.state.t, _own(seen.reference, name))
            safe = self._trail("replanned", name, seen.state.t, _own(seen.reference_safe, name))
            flown = self._trail("flown", name, seen.state.t, seen.state.pos[row])
            pale = (*own[:3], 0.35)
            made += [
                Shape(ShapeKind.LINE, "plan", row, pale, self._plans.get(name, planned), (THIN, 0.0, 0.0)),
                Shape(ShapeKind.LINE, "replanned", row, REPLANNED, safe, (THIN, 0.0, 0.0)),
                Shape(ShapeKind.LINE, "flown", row, own, flown, (THIN, 0.0, 0.0)),
            ]
        return [shape for shape in made if len(shape.points) > 1]

    def _trail(self, group: str, name: str, t: float, pos: Array | None) -> tuple[Three, ...]:
        trail = self._trails.setdefault((group, name), Trail())
        trail.forget(t, self._params.trail_s)
        if pos is not None and np.isfinite(pos).all():
            trail.add(t, point_of(pos), self._params.trail_hz)
        return trail.as_points()


def zones_breached(pos: Array, zone: Cylinder) -> NDArray[np.bool_]:
    """Return which vehicles at pos [m], (n, 3), have another in their zone, (n,)."""
    inside = zone.signed_distance(pos[None, :] - pos[:, None]) < 0.0  # (n, n)
    np.fill_diagonal(inside, val=False)
    return np.asarray(inside.any(axis=1))


def _own(signal: Interference | SwarmSetpoint | None, name: str) -> Array | None:
    """Return a vehicle's push [m/s^2] or planned position [m]; None without one."""
    if signal is None or name not in signal.names:
        return None
    values = signal.acc if isinstance(signal, Interference) else signal.pos
    return np.asarray(values[signal.names.index(name)])


def _colour(row: int, status: int) -> Colour:
    if status == TrackStatus.LOST:
        return LOST
    return COASTING if status == TrackStatus.COASTING else COLOURS[row % len(COLOURS)]
