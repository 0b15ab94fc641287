"""Moving picture of the README: a Crazyflie passes over another, ignoring the downwash and aware of it.

The flight is table6_room in the air learned from real flights (`room`), by the closed loop, from the side:

| drawn | meaning |
|---|---|
| bar with two rotors | vehicle with its roll, at 1.5 times its size |
| cone | downwash of the upper vehicle, about as wide as it is |
| curves at the right | height of the lower vehicle so far, in both flights |
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.animation import FuncAnimation, PillowWriter
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Polygon

from q2q_model import palette
from q2q_model.flights.flight import Flight
from q2q_model.geometry.rotations import rotate
from q2q_model.model_files.find_model import find_model
from q2q_model.signals.values import Array
from q2q_sim.air.lookup.find_air import find_air
from q2q_sim.loop.closed_loop import FlightOptions, fly
from q2q_sim.loop.flight_blocks import Mode
from q2q_sim.scenarios import library
from q2q_sim.scenarios.scenario_variants import with_air

SCENARIO, AIR, LOWER = "table6_room", "room", "cf1"
BEGINS, ENDS = 14.0, 42.0
"""Part of the flight that is shown [s]: from before the passage until the lower vehicle is back."""
SPEED, RATE = 4.0, 12.0
"""Seconds of flight per second shown [1], pictures per second [1/s]."""
ARM = 1.5 * 0.046
"""Half the length of a drawn vehicle [m]: 1.5 times the Crazyflie's arm, to be seen."""
DPI = 72
FLIGHTS: tuple[tuple[Mode, str, str], ...] = (
    ("ignoring", "ignoring the downwash", palette.FLIGHTS[0]),
    ("aware", "aware of it (q2q)", palette.FLIGHTS[1]),
)
"""Mode, title and colour of the two flights."""


@dataclass(frozen=True, slots=True)
class SideView:
    """Picture of one flight from the side."""

    flight: Flight
    bodies: Sequence[Line2D]
    """Vehicles, the lower one first."""
    cone: Polygon
    height: Line2D

    def show(self, tick: int) -> list[Artist]:
        """Draw the vehicles at a tick; return what has changed."""
        row = self.flight.names.index(LOWER)
        for k, body in zip((row, 1 - row), self.bodies, strict=True):
            body.set_data(*_outline(self.flight.true_pos[tick, k], self.flight.quat[tick, k]))
        _, y, z = self.flight.true_pos[tick, 1 - row]
        self.cone.set_xy([(y - ARM, z), (y + ARM, z), (y + 3.0 * ARM, z - 1.2), (y - 3.0 * ARM, z - 1.2)])
        since = int(np.searchsorted(self.flight.t, BEGINS))
        self.height.set_data(self.flight.t[since:tick], self.flight.true_pos[since:tick, row, 2])
        return [*self.bodies, self.cone, self.height]


def write_animation(out: Path) -> Path:
    """Fly both flights and write their picture; return the file."""
    figure = Figure(figsize=(11.0, 3.2), dpi=DPI, layout="constrained")
    axes = figure.subplots(1, 3, width_ratios=(1.0, 1.0, 1.3))
    flights = [_flight(mode) for mode, _, _ in FLIGHTS]
    for one, (_, title, colour) in zip(axes, FLIGHTS, strict=False):
        _label_side(one, title, colour)
    _label_heights(axes[2], flights[0])
    colours = [colour for _, _, colour in FLIGHTS]
    views = [_side_view(*each, axes[2]) for each in zip(axes, flights, colours, strict=False)]
    ticks = np.searchsorted(flights[0].t, np.arange(BEGINS, ENDS, SPEED / RATE))

    def show(tick: int) -> list[Artist]:
        return [artist for view in views for artist in view.show(tick)]

    path = out / "passage.gif"
    FuncAnimation(figure, show, [int(tick) for tick in ticks]).save(path, PillowWriter(fps=int(RATE)))
    return path


def _flight(mode: Mode) -> Flight:
    scenario = with_air(library.load(SCENARIO), AIR, ())
    model = find_model(scenario.model).interaction
    return fly(scenario, FlightOptions(mode=mode, model=model, air=find_air(AIR)))


def _outline(pos: Array, quat: Array) -> tuple[list[float], list[float]]:
    """Return the y and z [m] of a vehicle's bar with its rotors above both ends."""
    left, up = rotate(quat, np.eye(3)[1:])
    ends = [pos + side * ARM * left for side in (-1.0, 1.0)]
    rotors = [[end + 0.3 * ARM * up + side * 0.6 * ARM * left for side in (-1.0, 0.0, 1.0)] for end in ends]
    points = np.array([*rotors[0], rotors[0][1], *ends, rotors[1][1], *rotors[1]])
    return list(points[:, 1]), list(points[:, 2])


def _label_side(axes: Axes, title: str, colour: str) -> None:
    axes.set_title(title, color=colour, fontsize=13)
    axes.set(xlim=(-0.75, 0.75), ylim=(1.05, 2.2), aspect="equal", xlabel="y [m]", ylabel="z [m]")
    axes.set_xticks([-0.5, 0.0, 0.5])
    axes.axhline(1.5, color=palette.REFERENCE, linestyle="--", linewidth=1.0)
    axes.spines[["top", "right"]].set_visible(False)


def _label_heights(axes: Axes, flight: Flight) -> None:
    axes.plot([BEGINS, ENDS], [1.5, 1.5], "--", color=palette.REFERENCE, linewidth=1.0)
    lowest = float(np.min(flight.true_pos[:, flight.names.index(LOWER), 2]))
    axes.set_title("height of the lower vehicle", fontsize=13)
    axes.set_box_aspect(0.6)
    axes.set(xlim=(BEGINS, ENDS), ylim=(lowest - 0.03, 1.6), xlabel="t [s]", ylabel="z [m]")
    axes.spines[["top", "right"]].set_visible(False)


def _side_view(axes: Axes, flight: Flight, colour: str, heights: Axes) -> SideView:
    cone = Polygon([(0.0, 0.0)] * 4, color=palette.AIR, alpha=0.35, linewidth=0.0)
    axes.add_patch(cone)
    bodies = [axes.plot([], [], color=shade, linewidth=2.5)[0] for shade in (colour, palette.BLACK)]
    return SideView(flight, bodies, cone, heights.plot([], [], color=colour, linewidth=2.0)[0])
