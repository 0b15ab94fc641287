"""Figure of measured and predicted downwash over time."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from q2q_model import palette
from q2q_model.signals.values import Array
from q2q_sim.report.panels import legend_above, literal, panels


@dataclass(frozen=True, slots=True)
class PredictedPush:
    """Vertical downwash of one vehicle, measured and predicted."""

    vehicle: str
    t: Array
    """[s], (T,)"""
    measured: Array
    """[m/s^2], (T,)"""
    exposed: NDArray[np.bool_]
    """Rows under another vehicle, (T,)."""
    predicted: Array
    """[m/s^2], (T,)"""


def prediction_figure(pushes: Sequence[PredictedPush]) -> Figure:
    """Draw measured and predicted vertical downwash, one panel for each vehicle on one scale."""
    figure, rows = panels(len(pushes), sharey=True)
    for one, axes in zip(pushes, rows, strict=True):
        axes.plot(one.t, one.measured, color=palette.GREY, alpha=0.5, linewidth=0.5, label="measured")
        under = np.where(one.exposed, one.measured, np.nan)
        axes.plot(one.t, under, color=palette.MEASURED, linewidth=2.2, label="measured, under another")
        axes.plot(one.t, one.predicted, color=palette.MODEL, linewidth=1.2, label="predicted", zorder=3.0)
        axes.set_ylabel("downwash z [m/s²]")
        axes.set_title(literal(one.vehicle))
    legend_above(figure, rows[0])
    rows[-1].set_xlabel("t [s]")
    return figure
