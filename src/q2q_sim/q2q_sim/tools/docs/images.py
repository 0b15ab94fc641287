"""Pictures of the documentation without a display: a simulated flight, and the downwash of a real one.

The simulated flight is table6 by the closed loop, so that its picture needs no ROS and is reproducible. The
real one is that of scripts/demo --real.
"""

import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d import Axes3D

from q2q_model import palette
from q2q_model.flights.flight import Flight
from q2q_model.model_files.find_model import find_model
from q2q_model.signals.values import Interference, SwarmState, TrackStatus
from q2q_sim.loop.closed_loop import FlightOptions, fly
from q2q_sim.loop.flight_blocks import plan_of
from q2q_sim.report.panels import save
from q2q_sim.scenarios import library
from q2q_sim.scenarios.scenario import Scenario
from q2q_sim.tools.demo.real_flight import find_flights, score_flights
from q2q_sim.tools.demo.real_flight_page import held_out_figure, median_flight
from q2q_sim.view.scene import SceneBuilder, SceneParams, SceneSignals
from q2q_sim.view.shapes import Scene, Shape, ShapeKind

OUT = Path("docs/images")
SCENARIO, LOWER = "table6", "cf1"
SHOWN_AT = 21.0
"""Time at which the upper vehicle of table6 is above the lower one [s]."""
FORCE_SCALE = 1.0
"""Length of an arrow for 1 m/s^2 [m]: shows downwash of a few tenths."""
ROUND = 24
"""Corners of a drawn circle."""
DPI = 100


def write_images() -> list[Path]:
    """Write flight.png and, where there are recorded flights, real_flight.png; return the files."""
    flights = find_flights([])
    if not flights.further:
        print(f"node_pages: real_flight.png is left as it is: {flights.origin}", file=sys.stderr)
        return [write_flight()]
    shown = median_flight(score_flights(flights).held_out.flights)
    return [write_flight(), save(held_out_figure(shown), OUT / "real_flight.png")]


def write_flight() -> Path:
    """Fly table6 ignoring the downwash and aware of it; write flight.png; return it."""
    scenario = library.load(SCENARIO)
    model = find_model(scenario.model).interaction
    ignoring = fly(scenario, FlightOptions(mode="ignoring", model=model))
    aware = fly(scenario, FlightOptions(mode="aware", model=model))
    figure = Figure(figsize=(10.0, 4.4))
    left = Axes3D(figure, rect=(0.03, 0.05, 0.46, 0.87), auto_add_to_figure=False)
    figure.add_axes(left)
    plot_scene(left, scene_at(scenario, aware, SHOWN_AT))
    left.set_title(f"as the view shows it, t = {SHOWN_AT:g} s")
    _plot_altitudes(figure, {"ignoring the downwash": ignoring, "aware of it": aware})
    OUT.mkdir(parents=True, exist_ok=True)
    path = OUT / "flight.png"
    figure.savefig(path, dpi=DPI)
    return path


def scene_at(scenario: Scenario, flight: Flight, t: float) -> Scene:
    """Return the view at time t [s] of a flight, with its past."""
    builder = SceneBuilder(SceneParams(force_scale=FORCE_SCALE))
    builder.take_plan(plan_of(scenario))
    last = int(np.searchsorted(flight.t, t))
    scenes = [builder.update(_scene_signals(flight, tick)) for tick in range(last + 1)]
    return scenes[-1]


def plot_scene(axes: Axes3D, scene: Scene) -> None:
    """Plot a scene's shapes, boxes and texts as visible marks."""
    for shape in scene.shapes:
        points = np.array(shape.points)  # (k, 3)
        if shape.kind is ShapeKind.BOX:
            axes.plot(*points.T, "s", color=shape.colour, markersize=9)
        elif shape.kind is ShapeKind.TEXT:
            axes.text(*points[0], f"  {shape.text}", color=shape.colour)
        elif shape.kind is ShapeKind.CYLINDER:
            _plot_cylinder(axes, shape)
        elif shape.kind is ShapeKind.ARROW:
            axes.quiver(*points[0], *(points[1] - points[0]), color=shape.colour, linewidth=2.5, zorder=20.0)
        else:
            axes.plot(*points.T, color=shape.colour, linewidth=1.8)
    axes.set(xlim=(-0.6, 0.6), ylim=(-2.0, 2.0), zlim=(0.4, 3.0))
    axes.set(xlabel="x [m]", ylabel="y [m]", zlabel="z [m]")
    axes.set_xticks([-0.5, 0.5])
    axes.set_yticks([-2.0, -1.0, 0.0, 1.0, 2.0])
    axes.set_box_aspect((1.2, 4.0, 2.6), zoom=0.95)
    axes.view_init(elev=12.0, azim=-28.0)


def _plot_cylinder(axes: Axes3D, shape: Shape) -> None:
    (x, y, z), (wide, _, high) = shape.points[0], shape.size
    angle, height = np.meshgrid(np.linspace(0.0, 2.0 * np.pi, ROUND), z + 0.5 * high * np.array([-1.0, 1.0]))
    around = 0.5 * wide * np.cos(angle), 0.5 * wide * np.sin(angle)
    axes.plot_surface(x + around[0], y + around[1], height, color=shape.colour[:3], alpha=0.12, shade=False)


def _plot_altitudes(figure: Figure, flights: dict[str, Flight]) -> None:
    axes = figure.add_axes((0.58, 0.13, 0.4, 0.7))
    for colour, (label, flight) in zip(palette.FLIGHTS, flights.items(), strict=False):
        row = flight.names.index(LOWER)
        axes.plot(flight.t, flight.true_pos[:, row, 2], color=colour, label=label)
    axes.plot(flight.t, flight.ref_pos[:, row, 2], "--", color=palette.REFERENCE, zorder=4.0, label="plan")
    axes.set(xlabel="t [s]", ylabel=f"z of {LOWER}, the lower vehicle [m]")
    axes.grid(alpha=0.3)
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3, frameon=False, fontsize="small")


def _scene_signals(flight: Flight, tick: int) -> SceneSignals:
    t, count = float(flight.t[tick]), len(flight.names)
    state = SwarmState(
        t=t,
        names=flight.names,
        pos=flight.true_pos[tick],
        vel=flight.true_vel[tick],
        quat=flight.quat[tick],
        ang_vel_body=np.zeros((count, 3)),
        age=np.zeros(count),
        status=np.full(count, TrackStatus.TRACKED, dtype=np.uint8),
    )
    interference = Interference(
        t=t,
        names=flight.names,
        acc=flight.eta[tick],
        std=np.zeros((count, 3)),
        status=np.zeros(count, dtype=np.uint8),
    )
    return SceneSignals(state, interference)
