"""Figures of cost against the number of vehicles, a panel for each block, both axes logarithmic."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cost_growth.points import Curve
from cost_growth.power_law import PowerLaw
from q2q_model import palette

COLUMNS = 3
SIZE = (3.6, 2.5)
"""Of a panel [inch]."""
STYLE = {"font.size": 9, "axes.titlesize": 10, "axes.grid": True, "grid.alpha": 0.3}


@dataclass(frozen=True, slots=True)
class Quantity:
    """What a figure shows of every curve."""

    label: str
    scale: float
    """Units of the label in one SI unit."""
    cost: Callable[[Curve], Sequence[tuple[float, float, float]]]
    """Median, least and most of each point."""
    reference: Callable[[Curve], Sequence[float]]
    law: Callable[[Curve], PowerLaw]
    beside: Callable[[Curve], str]


TIME = Quantity(
    "time [us]",
    1e6,
    lambda curve: [(one.seconds, one.least, one.most) for one in curve.points],
    lambda curve: [one.reference for one in curve.points],
    lambda curve: curve.time_law,
    lambda curve: curve.beside,
)
MEMORY = Quantity(
    "arrays held [kB]",
    1e-3,
    lambda curve: [(one.held, one.held, one.held) for one in curve.points],
    lambda curve: [one.message for one in curve.points],
    lambda curve: curve.memory_law,
    lambda _: "one state message",
)


def growth_figure(curves: Sequence[Curve], shown: Quantity) -> Figure:
    """Draw a quantity of every block: points with spread, fitted law with its bend, reference."""
    rows = -(-len(curves) // COLUMNS)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(SIZE[0] * COLUMNS, SIZE[1] * rows), layout="constrained")
        panels = figure.subplots(rows, COLUMNS, sharex=True, squeeze=False)
    for axes, curve in zip(panels.flat, curves, strict=False):
        _draw(axes, curve, shown)
    for axes in panels.flat[len(curves) :]:
        axes.axis("off")
    for axes in panels[:, 0]:
        axes.set_ylabel(shown.label)
    for axes in panels.flat[max(len(curves) - COLUMNS, 0) : len(curves)]:  # the lowest of each column
        axes.set_xlabel("vehicles")
        axes.tick_params(labelbottom=True)
    return figure


def _draw(axes: Axes, curve: Curve, shown: Quantity) -> None:
    law, sizes = shown.law(curve), curve.sizes
    middle, least, most = shown.scale * np.array(shown.cost(curve)).T
    beside = shown.scale * np.array(shown.reference(curve))
    axes.plot(sizes, beside, "--", color=palette.REFERENCE, label=shown.beside(curve))
    along = np.geomspace(sizes[0], sizes[-1], 50)
    axes.plot(along, shown.scale * law.cost(along), color=palette.MODEL, label=exponents(law))
    spread = np.array([middle - least, most - middle])
    axes.errorbar(sizes, middle, spread, fmt="o", color=palette.MEASURED, markersize=3, capsize=2)
    if law.bent:
        axes.axvline(law.origin, color=palette.REFERENCE, linestyle=":")
    axes.set(xscale="log", yscale="log", title=curve.block)
    axes.legend(fontsize=7, edgecolor="none")  # its frame hides the bend's line, not the text


def exponents(law: PowerLaw) -> str:
    """Return a law's exponents as text."""
    if not law.bent:
        return f"n^{law.below.value:.2f}"
    return f"n^{law.below.value:.2f}, n^{law.above.value:.2f} from {law.origin:.0f}"
