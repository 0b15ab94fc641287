"""Figures of flights, as the paper's Figs 14a-d: quantities of each vehicle over time.

Each vehicle of a flight has its own figures, on one scale. A quantity of one value overlays the flights; a
quantity of two has one panel for each flight.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from q2q_model import palette
from q2q_model.flights.flight import Flight, of_vehicle
from q2q_model.signals.values import Array, CommandStatus
from q2q_sim.monitors.metrics.flight_metrics import best_position
from q2q_sim.report.panels import legend_above, literal, panel_title, panels

ALONE = 1.5
"""Width of a trace with no other over it [pt]."""
PADDING = 0.06
"""Space above and below the curves, as a share of their range."""
NEAR = 0.5
"""Distance of a limit from the curves up to which it is drawn, as a share of their range."""


@dataclass(frozen=True, slots=True)
class PlotCurve:
    """Flight and its legend."""

    flight: Flight
    label: str
    thrust_max: float = np.nan
    """Largest thrust of its vehicles [N], where no two ticks show the controller's limit."""


@dataclass(frozen=True, slots=True)
class TimeTrace:
    """Value over time of each vehicle, and its looks."""

    of: Callable[[Flight], Array]
    """(T, n)"""
    label: str = ""
    colour: str = palette.MODEL
    width: float = 1.5
    """[point]"""


@dataclass(frozen=True, slots=True)
class Quantity:
    """Quantity of a flight that has a figure for each vehicle."""

    title: str
    axis: str
    traces: tuple[TimeTrace, ...]
    least: float
    """Range below which there is nothing to see."""
    reference: Callable[[Flight], Array] | None = None
    limits: Callable[[Sequence[PlotCurve]], Mapping[float, str]] = field(default=lambda _: {})
    """Values of limits and their legends."""
    centred: bool = False
    """Whether vehicles share the length of the scale alone, not its ends."""


def recorded_vehicles(quantity: Quantity, curves: Sequence[PlotCurve]) -> list[str]:
    """Return the vehicles of which a quantity was recorded; none if there is nothing to see of any."""
    recorded = _recorded(quantity, curves)
    visible = any(np.ptp(_known(quantity, curves, name)) >= quantity.least for name in recorded)
    return recorded if visible else []


def plot_quantity(quantity: Quantity, curves: Sequence[PlotCurve], name: str) -> Figure:
    """Plot a quantity of the vehicle `name` in each flight."""
    apart, curves = len(quantity.traces) > 1, _with(curves, name)
    figure, axes = panels(len(curves) if apart else 1)
    traces = [one for one in quantity.traces if _is_recorded(one, curves, name)]
    for k, curve in enumerate(curves):
        panel = axes[k if apart else 0]
        for trace in traces:
            colour = trace.colour if apart else palette.FLIGHTS[k % len(palette.FLIGHTS)]
            values = _of(curve.flight, name, trace.of)
            panel.plot(
                _since_first_tick(curve.flight),
                values,
                color=colour,
                linewidth=trace.width if len(traces) > 1 else ALONE,
                label=trace.label if apart else literal(curve.label),
            )
        panel.set_title(panel_title(name, quantity.title, curve.label if apart else ""))
    for panel in axes:
        panel.set_ylabel(quantity.axis)
        panel.set_ylim(*_ends(quantity, curves, name))
    _plot_reference(axes[0], quantity, curves[0].flight, name)
    for limit, words in quantity.limits(curves).items():
        _plot_limit(axes[0], limit, words)
    legend_above(figure, axes[0])
    axes[-1].set_xlabel("t [s]")
    return figure


def thrust_limits(curves: Sequence[PlotCurve]) -> Mapping[float, str]:
    """Return the thrusts at which commands were cut [N], else the largest of the vehicles."""
    seen = {float(limit) for one in curves if np.isfinite(limit := _saturated_at(one.flight))}
    known = seen or {one.thrust_max for one in curves if np.isfinite(one.thrust_max)}
    return {limit: f"limit {limit:.3g} N" for limit in sorted(known)}


def _saturated_at(flight: Flight) -> float:
    """Return the thrust at which commands were cut [N]; nan if none was.

    Commands cut in thrust have the largest one, to the last bit; a vehicle's commands cut in tilt alone
    differ from each other.
    """
    computed = flight.thrust[flight.command_status <= CommandStatus.SATURATED]
    most = float(np.nanmax(computed, initial=-np.inf))
    cut = (flight.command_status == CommandStatus.SATURATED) & (flight.thrust == most)
    return most if cut.sum(axis=0).max(initial=0) > 1 else float("nan")


def _since_first_tick(flight: Flight) -> Array:
    return flight.t - flight.t[:1]


def _horizontal_error(flight: Flight) -> Array:
    error = best_position(flight) - flight.ref_pos
    return np.hypot(error[..., 0], error[..., 1])


KINDS: dict[str, Quantity] = {
    "altitude": Quantity(
        "altitude",
        "z [m]",
        (TimeTrace(lambda flight: best_position(flight)[..., 2]),),
        least=0.0,
        reference=lambda flight: flight.ref_pos[..., 2],
        centred=True,
    ),
    "sideways": Quantity(
        "horizontal error", "horizontal error [m]", (TimeTrace(_horizontal_error),), least=1e-3
    ),
    "downwash": Quantity(
        "vertical push of the air",
        "push z [m/s²]",
        (
            TimeTrace(lambda flight: flight.true_eta[..., 2], "true", palette.MEASURED, width=3.5),
            TimeTrace(lambda flight: flight.eta[..., 2], "predicted downwash", palette.MODEL),
        ),
        least=0.01,
    ),
    "thrust": Quantity(
        "collective thrust",
        "thrust U1 [N]",
        (TimeTrace(lambda flight: flight.thrust),),
        least=0.0,
        limits=thrust_limits,
    ),
    "tilt": Quantity(
        "commanded roll and pitch",
        "angle [°]",
        (
            TimeTrace(lambda flight: np.degrees(flight.roll), "roll", palette.ROLL),
            TimeTrace(lambda flight: np.degrees(flight.pitch), "pitch", palette.PITCH),
        ),
        least=0.5,
    ),
}
"""Quantities of a report by the end of their files' names."""


def _plot_reference(axes: Axes, quantity: Quantity, flight: Flight, name: str) -> None:
    """Plot the reference in front of the curves."""
    if quantity.reference is not None:
        values = _of(flight, name, quantity.reference)
        axes.plot(
            _since_first_tick(flight), values, "--", color=palette.REFERENCE, label="reference", zorder=4.0
        )


def _plot_limit(axes: Axes, limit: float, words: str) -> None:
    """Plot a limit near the curves; name one that is far from them in the legend alone."""
    low, high = axes.get_ylim()
    if low - NEAR * (high - low) <= limit <= high + NEAR * (high - low):
        axes.axhline(limit, linestyle=":", color=palette.REFERENCE, label=words, linewidth=1.5)
        room = PADDING * (high - low)
        axes.set_ylim(min(low, limit - room), max(high, limit + room))
    else:
        axes.plot([], [], " ", label=f"{words}, out of view")


def _ends(quantity: Quantity, curves: Sequence[PlotCurve], name: str) -> tuple[float, float]:
    """Return the ends of the scale, which all vehicles share."""
    values = {row: _known(quantity, curves, row) for row in _recorded(quantity, curves)}
    if not values:
        return 0.0, 1.0
    if quantity.centred and name in values:
        half = 0.5 * max(np.ptp(one) for one in values.values())
        middle = 0.5 * (values[name].min() + values[name].max())
        low, high = middle - half, middle + half
    else:
        low, high = min(one.min() for one in values.values()), max(one.max() for one in values.values())
    room = PADDING * (high - low) or max(quantity.least, 1e-3)
    return float(low - room), float(high + room)


def _recorded(quantity: Quantity, curves: Sequence[PlotCurve]) -> list[str]:
    return [name for name in curves[0].flight.names if _known(quantity, curves, name).size]


def _known(quantity: Quantity, curves: Sequence[PlotCurve], name: str) -> Array:
    """Return the finite values of a vehicle in all flights."""
    of = [one.of for one in quantity.traces] + ([quantity.reference] if quantity.reference else [])
    flown = _with(curves, name)
    values: Array = np.concatenate([_of(curve.flight, name, one) for curve in flown for one in of])
    return np.asarray(values[np.isfinite(values)])


def _is_recorded(trace: TimeTrace, curves: Sequence[PlotCurve], name: str) -> bool:
    return any(np.isfinite(_of(curve.flight, name, trace.of)).any() for curve in curves)


def _with(curves: Sequence[PlotCurve], name: str) -> list[PlotCurve]:
    return [one for one in curves if name in one.flight.names]


def _of(flight: Flight, name: str, values: Callable[[Flight], Array]) -> Array:
    column: Array = values(of_vehicle(flight, name))[:, 0]
    return column
