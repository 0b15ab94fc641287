"""Figures of flights, as the paper's Figs 14a-d: altitude and U1 of each vehicle over time."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from q2q_model.flights.flight import Flight
from q2q_model.signals.values import Array
from q2q_sim.monitors.metrics import best_position

COLOURS = ("#c0392b", "#1f77b4", "#2a9d55", "#8e44ad")
"""One for each flight; the first is the reference."""
REFERENCE_COLOUR = "#555555"
DPI = 130


@dataclass(frozen=True, slots=True)
class PlotCurve:
    """Flight and its legend."""

    flight: Flight
    label: str


def altitude_figure(curves: Sequence[PlotCurve], name: str) -> Figure:
    """Draw z [m] of the vehicle `name` in each flight, with its reference."""
    figure, axes = _axes(f"{name}: altitude", "z [m]")
    flight = curves[0].flight
    axes.plot(
        flight.t, _of(flight, name, flight.ref_pos)[:, 2], "--", color=REFERENCE_COLOUR, label="reference"
    )
    for curve, colour in zip(curves, COLOURS, strict=False):
        z = _of(curve.flight, name, best_position(curve.flight))[:, 2]
        axes.plot(curve.flight.t, z, color=colour, label=curve.label)
    axes.legend()
    return figure


def thrust_figure(curves: Sequence[PlotCurve], name: str) -> Figure:
    """Draw the commanded collective thrust U1 [N] of the vehicle `name` in each flight."""
    figure, axes = _axes(f"{name}: collective thrust", "U1 [N]")
    for curve, colour in zip(curves, COLOURS, strict=False):
        axes.plot(
            curve.flight.t, _of(curve.flight, name, curve.flight.thrust), color=colour, label=curve.label
        )
    axes.legend()
    return figure


def downwash_figure(curves: Sequence[PlotCurve], name: str) -> Figure:
    """Draw the vertical downwash eta_z [m/s^2] of vehicle `name`: predicted, and true if known."""
    figure, axes = _axes(f"{name}: vertical downwash", "eta z [m/s²]")
    for curve, colour in zip(curves, COLOURS, strict=False):
        flight = curve.flight
        axes.plot(
            flight.t, _of(flight, name, flight.eta)[:, 2], color=colour, label=f"{curve.label}, predicted"
        )
        axes.plot(flight.t, _of(flight, name, flight.true_eta)[:, 2], ":", color=colour)
    axes.legend()
    return figure


def tilt_figure(curves: Sequence[PlotCurve], name: str) -> Figure:
    """Draw the commanded roll (solid) and pitch (dotted) [rad] of the vehicle `name`."""
    figure, axes = _axes(f"{name}: commanded roll and pitch", "[rad]")
    for curve, colour in zip(curves, COLOURS, strict=False):
        flight = curve.flight
        axes.plot(flight.t, _of(flight, name, flight.roll), color=colour, label=curve.label)
        axes.plot(flight.t, _of(flight, name, flight.pitch), ":", color=colour)
    axes.legend()
    return figure


def sideways_figure(curves: Sequence[PlotCurve], name: str) -> Figure:
    """Draw the horizontal distance from the plan [m] of the vehicle `name`."""
    figure, axes = _axes(f"{name}: horizontal error", "[m]")
    for curve, colour in zip(curves, COLOURS, strict=False):
        flight = curve.flight
        error = _of(flight, name, best_position(flight) - flight.ref_pos)
        axes.plot(flight.t, np.hypot(error[:, 0], error[:, 1]), color=colour, label=curve.label)
    axes.legend()
    return figure


KINDS: dict[str, Callable[[Sequence[PlotCurve], str], Figure]] = {
    "altitude": altitude_figure,
    "sideways": sideways_figure,
    "downwash": downwash_figure,
    "thrust": thrust_figure,
    "tilt": tilt_figure,
}
"""Figures of a report, one for each vehicle."""


def save(figure: Figure, path: Path) -> Path:
    """Write a figure as PNG; return its path."""
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=DPI)
    return path


def _axes(title: str, quantity: str) -> tuple[Figure, Axes]:
    with mpl.rc_context({"font.size": 10, "axes.grid": True, "grid.alpha": 0.3}):
        figure = Figure(figsize=(7.2, 3.6), layout="constrained")
        axes = figure.add_subplot()
    axes.set_title(title)
    axes.set_xlabel("t [s]")
    axes.set_ylabel(quantity)
    return figure, axes


def _of(flight: Flight, name: str, values: Array) -> Array:
    return values[:, flight.names.index(name)]
