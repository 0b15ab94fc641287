"""Figures of recorded and simulated height errors over each other."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from q2q_model import palette
from q2q_sim.experiments.validation.error_spectrum import EDGES
from q2q_sim.experiments.validation.error_statistics import ErrorSums
from q2q_sim.experiments.validation.validated_flight import ValidatedFlight
from q2q_sim.report.panels import legend_above, literal, panels
from q2q_sim.report.significant_digits import CM


def error_figure(one: ValidatedFlight) -> Figure:
    """Draw the height error of each compared vehicle over time, with the rows under a wake shaded."""
    parts = one.under if one.has_wake else one.clear
    vehicles = [i for i, part in enumerate(parts) if part.n]
    figure, rows = panels(len(vehicles), sharey=True)
    for axes, i in zip(rows, vehicles, strict=True):
        _plot_errors(axes, one, i)
        axes.set_title(literal(f"{one.flight.names[i]}: height error"))
        axes.set_ylabel("z − z_ref [cm]")
    legend_above(figure, rows[0])
    rows[-1].set_xlabel("t [s]")
    return figure


def spectrum_figure(parts: Sequence[ErrorSums], title: str) -> Figure:
    """Draw the mean density of recorded and simulated errors in each octave band; some have segments."""
    scale = CM**2 / (sum(part.segments for part in parts) * np.diff(EDGES))
    recorded = scale * sum(part.power for part in parts)
    drawn = scale * sum(part.power_drawn for part in parts)
    figure, (axes,) = panels(1)
    for power, colour, label in (
        (recorded, palette.MEASURED, "recorded"),
        (drawn, palette.MODEL, "simulated"),
    ):
        axes.stairs(power, EDGES, color=colour, label=label, baseline=None, linewidth=2)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_title(title)
    axes.set_xlabel("frequency [Hz]")
    axes.set_ylabel("density [cm²/Hz]")
    axes.set_xticks([0.2, 0.5, 1.0, 2.0, 5.0, 10.0], ["0.2", "0.5", "1", "2", "5", "10"])
    axes.minorticks_off()
    legend_above(figure, axes)
    return figure


def _plot_errors(axes: Axes, one: ValidatedFlight, i: int) -> None:
    t, drawn = one.flight.t, CM * one.drawn[..., i]
    low, middle, high = np.percentile(drawn, [2.5, 50.0, 97.5], axis=0)
    axes.fill_between(t, low, high, color=palette.MODEL, alpha=0.25, linewidth=0, label="95 % of draws")
    axes.plot(t, middle, color=palette.MODEL, linewidth=1.2, label="median draw")
    axes.plot(t, CM * one.flight.error[:, i], color=palette.MEASURED, linewidth=0.9, label="recorded")
    axes.fill_between(
        t,
        0.0,
        1.0,
        where=one.flight.exposed[:, i],
        transform=axes.get_xaxis_transform(),
        color=palette.WAKE,
        alpha=0.2,
        linewidth=0,
        label="under a wake",
    )
