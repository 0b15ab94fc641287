"""Figures of a plan as in the paper: curves and distances (Figs 10, 12), z (11, 13), and a 3-D view."""

from itertools import combinations
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")  # files only: no display

import numpy as np
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d import Axes3D

from q2q_model import palette
from q2q_model.documents.written_file import naming_written
from q2q_model.downwash.interaction_model import InteractionModel
from q2q_model.geometry.zone import Zone
from q2q_model.signals.values import Array, Names
from q2q_model.trajectory.polynomials import SwarmPlan, setpoint_at
from q2q_model.vehicle.altitude_loop import PAPER_LOOP
from q2q_planner.offline.certificate.certificate import certify
from q2q_planner.offline.certificate.convex_zone import zone_around
from q2q_planner.offline.zones.altitude_response import altitude_errors
from q2q_planner.online.safe.safe_replanner import SafeReplanner
from q2q_planner.tools.figure_zone import params_of_zone

TICK = 0.02
"""Sampling of curves [s]."""
MOST_PAIRS = 12
"""Most relative distances drawn: of the pairs that come nearest."""


def draw_all(
    folder: Path, plan: SwarmPlan, free: SwarmPlan, zone: Zone, model: InteractionModel
) -> list[Path]:
    """Draw Figs 10 to 13 and the 3-D view into a folder; return the files.

    Args:
        folder: output folder, created if missing.
        plan: plan with avoidance.
        free: minimum-snap plan without avoidance, the reference of the online replanner.
        zone: zone to avoid.
        model: downwash in which heights are simulated.
    """
    folder.mkdir(parents=True, exist_ok=True)
    t = np.arange(0.0, plan.duration + TICK, TICK)
    avoiding, reference = plan.positions(t), free.positions(t)
    online = replan_samples(free, t, zone)
    both = {"without avoidance": reference, "with avoidance": avoiding}
    fig10 = _beside(plan, both, zone)
    fig12 = _beside(plan, {"reference": reference, "modified online": online}, zone)
    return [
        _kept(fig10, folder / "fig10.png"),
        _kept(_heights(plan, both, model), folder / "fig11.png"),
        _kept(fig12, folder / "fig12.png"),
        _kept(_heights(plan, {"modified online": online}, model), folder / "fig13.png"),
        _kept(_solid(plan, avoiding, zone), folder / "plan_and_zone.png"),
    ]


def replan_samples(plan: SwarmPlan, t: Array, zone: Zone) -> Array:
    """Return the plan after the safe replanner, (T, n, 3), with the zone's radius and half height."""
    replanner = SafeReplanner(params_of_zone(zone))
    return np.stack([replanner.update(setpoint_at(plan, float(at)), None).pos for at in t])


def _heights(plan: SwarmPlan, curves: dict[str, Array], model: InteractionModel) -> Figure:
    """Draw z of each vehicle and its reference, simulated in the downwash; one column per curve."""
    shape = len(plan.names), len(curves)
    figure, axes = plt.subplots(*shape, sharex=True, figsize=(5.5 * shape[1], 2.4 * shape[0]), squeeze=False)
    for column, (title, pos) in enumerate(curves.items()):
        errors = altitude_errors(pos, TICK, model, PAPER_LOOP)
        t = TICK * np.arange(len(pos))
        for row, name in enumerate(plan.names):
            axis: Axes = axes[row, column]
            axis.plot(t, pos[:, row, 2], "--", color=palette.REFERENCE, label="reference", zorder=4.0)
            axis.plot(
                t, pos[:, row, 2] + errors[:, row], color=palette.MODEL, linewidth=0.8, label="simulated"
            )
            axis.set_ylabel("z [m]")
            axis.set_title(f"{name}, {title}: RMS {np.sqrt((errors[:, row] ** 2).mean()):.4f} m")
    axes[0, 0].legend()
    for axis in axes[-1]:
        axis.set_xlabel("t [s]")
    return _checked(figure)


def _checked(figure: object) -> Figure:
    if not isinstance(figure, Figure):
        raise TypeError(f"matplotlib returned a {type(figure).__name__}, expected a Figure")
    return figure


def _beside(plan: SwarmPlan, curves: dict[str, Array], zone: Zone) -> Figure:
    """Draw trajectories above relative distances, one column per curve."""
    figure = plt.figure(figsize=(5.5 * len(curves), 8.5))
    below: list[Axes] = []
    for column, (title, pos) in enumerate(curves.items()):
        space = figure.add_subplot(2, len(curves), column + 1, projection="3d")
        _paths(space, plan.names, pos)
        space.set_title(title)
        space.set_aspect("equal")
        below.append(figure.add_subplot(2, len(curves), len(curves) + column + 1))
        _distances(below[-1], plan, pos, zone)
    low, high = (pick(axis.get_ylim()[k] for axis in below) for k, pick in enumerate((min, max)))
    for axis in below:
        if low < 0.0:
            axis.axhspan(low, 0.0, color=palette.ZONE, alpha=0.4, label="inside the zone")
        axis.set_ylim(low, high)
        axis.legend(fontsize="small", loc="lower right")
    return _checked(figure)


def _distances(axis: Axes, plan: SwarmPlan, pos: Array, zone: Zone) -> None:
    """Draw the signed distance of the nearest pairs to the zone over time."""
    pairs, t = list(combinations(range(pos.shape[1]), 2)), TICK * np.arange(len(pos))
    distances = [zone.signed_distance(pos[:, i] - pos[:, j]) for i, j in pairs]
    nearest = np.argsort([distance.min() for distance in distances])[:MOST_PAIRS]
    for row in nearest:
        i, j = pairs[row]
        axis.plot(t, distances[row], label=f"{plan.names[i]}, {plan.names[j]}")
    axis.set_xlabel("t [s]")
    axis.set_ylabel("distance to the zone [m]")


def _solid(plan: SwarmPlan, pos: Array, zone: Zone) -> Figure:
    """Draw every vehicle, with the zone around one at the time when a pair is nearest by its certificate."""
    proof = certify(plan, zone)
    figure = plt.figure(figsize=(7, 7))
    space = figure.add_subplot(projection="3d")
    _paths(space, plan.names, pos)
    if proof.pair and not proof.not_computed:
        nearest, below = plan.positions(np.array([proof.t]))[0], proof.pair[1]
        centre = nearest[plan.names.index(below)]
        space.plot_surface(*(_surface(zone) + centre[:, None, None]), color=palette.ZONE, alpha=0.4)
        space.scatter(*nearest.T, color="black", s=12)
        space.set_title(f"vehicles (black) when nearest, t = {proof.t:.2f} s, and zone around {below}")
    space.set_aspect("equal")
    return _checked(figure)


def _paths(space: Axes3D, names: Names, pos: Array) -> None:
    """Draw the path of every vehicle."""
    for row, name in enumerate(names):
        space.plot(*pos[:, row].T, color=palette.VEHICLES[row % len(palette.VEHICLES)], label=name)
    space.set(xlabel="x [m]", ylabel="y [m]", zlabel="z [m]")
    for axis in "xyz":
        space.locator_params(axis=axis, nbins=4)
    if len(names) <= MOST_PAIRS:
        space.legend(loc="upper left", fontsize="small")


def _surface(zone: Zone) -> Array:
    """Return the zone's hull as a mesh, (3, heights, angles)."""
    profile = zone_around(zone).profile
    upper = np.concatenate([[[profile[0, 0], 0.0]], profile, [[0.0, profile[-1, 1]]]])
    outline = np.concatenate([upper[::-1] * [1.0, -1.0], upper])
    angle = np.linspace(0.0, 2.0 * np.pi, 49)
    radius, height = outline[:, :1], outline[:, 1:]
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), height + 0.0 * angle])


def _kept(figure: Figure, path: Path) -> Path:
    figure.tight_layout()
    with naming_written(path):
        figure.savefig(path, dpi=110)
    plt.close(figure)
    return path
