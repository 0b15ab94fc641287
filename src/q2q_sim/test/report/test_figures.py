"""Figures of flights: one scale for the vehicles, limits drawn, nothing empty."""

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

from q2q_model import palette
from q2q_model.flights.flight import Flight
from q2q_model.signals.values import Array, CommandStatus
from q2q_sim.loop.flight_recorder import FlightRecorder
from q2q_sim.report.figures import KINDS, PlotCurve, plot_quantity, recorded_vehicles, thrust_limits

TICKS, NAMES = 50, ("cf1", "cf2")


@pytest.fixture
def flight() -> Flight:
    """Return a flight in which cf1 sags by 0.3 m and cf2 by 0.1 m, half a metre higher."""
    empty = FlightRecorder(NAMES, TICKS).flight("made")
    ref = np.zeros((TICKS, 2, 3))
    ref[..., 2] = 1.5, 2.0
    true = ref.copy()
    true[:, :, 2] -= np.sin(np.linspace(0.0, np.pi, TICKS))[:, None] * [0.3, 0.1]
    thrust = 0.3 + 0.02 * np.sin(np.linspace(0.0, 6.0, TICKS))[:, None] * np.ones(2)
    return replace(empty, t=0.01 * np.arange(TICKS), ref_pos=ref, true_pos=true, thrust=thrust)


def drawn(flight: Flight, kind: str, name: str, label: str) -> Array:
    """Return the values of the curve with a label."""
    axes = plot_quantity(KINDS[kind], [PlotCurve(flight, "flown")], name).axes[0]
    (line,) = [one for one in axes.lines if one.get_label() == label]
    return np.asarray(line.get_ydata())


def test_vehicles_at_different_heights_are_drawn_on_one_scale(flight: Flight) -> None:
    ends = [
        plot_quantity(KINDS["altitude"], [PlotCurve(flight, "flown")], name).axes[0].get_ylim()
        for name in NAMES
    ]
    assert np.ptp(ends[0]) == pytest.approx(np.ptp(ends[1]))
    assert np.ptp(ends[0]) == pytest.approx(0.3 * 1.12, rel=0.01)


def test_the_curve_is_the_true_altitude_and_the_reference_lies_in_front(flight: Flight) -> None:
    assert drawn(flight, "altitude", "cf2", "flown") == pytest.approx(flight.true_pos[:, 1, 2])
    axes = plot_quantity(KINDS["altitude"], [PlotCurve(flight, "flown")], "cf1").axes[0]
    front = max(axes.lines, key=lambda line: line.get_zorder())
    assert front.get_label() == "reference"


def test_what_was_not_recorded_or_cannot_be_seen_has_no_figure(flight: Flight) -> None:
    curves = [PlotCurve(flight, "flown")]
    found = {kind: recorded_vehicles(quantity, curves) for kind, quantity in KINDS.items()}
    nothing = {"sideways": [], "downwash": [], "tilt": []}
    assert found == nothing | {"altitude": list(NAMES), "thrust": list(NAMES)}
    thrust = flight.thrust.copy()
    thrust[:, 1] = np.nan
    assert recorded_vehicles(KINDS["thrust"], [PlotCurve(replace(flight, thrust=thrust), "flown")]) == ["cf1"]


def test_a_trace_that_no_flight_recorded_is_not_in_the_legend(flight: Flight) -> None:
    unpredicted = replace(flight, true_eta=np.ones((TICKS, 2, 3)), eta=np.full((TICKS, 2, 3), np.nan))
    panel = plot_quantity(KINDS["downwash"], [PlotCurve(unpredicted, "flown")], "cf1").axes[0]
    assert [line.get_label() for line in panel.lines] == ["true"]


def test_roll_and_pitch_have_two_colours_and_each_flight_a_panel(flight: Flight) -> None:
    tilted = replace(flight, roll=np.full((TICKS, 2), 0.1), pitch=np.full((TICKS, 2), -0.2))
    curves = [PlotCurve(tilted, "first"), PlotCurve(tilted, "second")]
    panels = plot_quantity(KINDS["tilt"], curves, "cf1").axes
    assert len(panels) == 2
    for panel in panels:
        roll, pitch = panel.lines
        assert (roll.get_color(), pitch.get_color()) == (palette.ROLL, palette.PITCH)
        assert np.asarray(roll.get_ydata())[0] == pytest.approx(np.degrees(0.1))
        assert np.asarray(pitch.get_ydata())[0] == pytest.approx(np.degrees(-0.2))


def test_the_thrust_limit_is_that_of_saturated_ticks_else_that_of_the_vehicle(flight: Flight) -> None:
    status = np.zeros((TICKS, 2))
    assert thrust_limits([PlotCurve(replace(flight, command_status=status), "", 0.6)]) == {0.6: "limit 0.6 N"}
    status[20:30, 0] = CommandStatus.SATURATED
    thrust = np.where(status == CommandStatus.SATURATED, 0.33, flight.thrust)
    saturated = PlotCurve(replace(flight, thrust=thrust, command_status=status), "flown", 0.6)
    assert list(thrust_limits([saturated])) == [0.33]
    axes = plot_quantity(KINDS["thrust"], [saturated], "cf2").axes[0]
    (limit,) = [line for line in axes.lines if str(line.get_label()).startswith("limit")]
    assert np.asarray(limit.get_ydata()) == pytest.approx(0.33)
    assert axes.get_ylim()[1] > 0.33


def test_commands_cut_in_tilt_alone_show_no_limit_of_thrust(flight: Flight) -> None:
    status = np.zeros((TICKS, 2))
    status[10:40] = CommandStatus.SATURATED
    tilted = replace(flight, command_status=status)  # both vehicles alike, as in a symmetric flight
    assert thrust_limits([PlotCurve(tilted, "", 0.6)]) == {0.6: "limit 0.6 N"}
    assert thrust_limits([PlotCurve(tilted, "")]) == {}
    thrust = flight.thrust.copy()
    thrust[12:14, 0] = 0.35  # cut in thrust too
    assert list(thrust_limits([PlotCurve(replace(tilted, thrust=thrust), "", 0.6)])) == [0.35]
    thrust[12:14, 0] = 0.02  # cut at the least thrust, which other commands exceed
    assert list(thrust_limits([PlotCurve(replace(tilted, thrust=thrust), "", 0.6)])) == [0.6]


def test_a_limit_far_from_the_curves_is_reported_and_does_not_flatten_them(flight: Flight) -> None:
    axes = plot_quantity(KINDS["thrust"], [PlotCurve(flight, "flown", 2.0)], "cf1").axes[0]
    assert axes.get_ylim()[1] < 0.4
    assert "limit 2 N, out of view" in [line.get_label() for line in axes.lines]


def test_a_vehicle_that_flew_in_one_flight_only_is_drawn_there(flight: Flight) -> None:
    other = replace(flight, names=("cf1", "cf9"))
    figure = plot_quantity(KINDS["altitude"], [PlotCurve(flight, "first"), PlotCurve(other, "second")], "cf2")
    assert [line.get_label() for line in figure.axes[0].lines] == ["first", "reference"]


def test_flights_of_different_days_lie_over_each_other_from_their_first_ticks(flight: Flight) -> None:
    days = [replace(flight, t=flight.t + since) for since in (1.7e9, 1.7e9 + 3600.0)]
    axes = plot_quantity(
        KINDS["altitude"], [PlotCurve(one, str(k)) for k, one in enumerate(days)], "cf1"
    ).axes[0]
    assert len(axes.lines) == 3  # both and the reference
    for line in axes.lines:
        assert np.asarray(line.get_xdata()) == pytest.approx(flight.t, abs=1e-6)


@pytest.mark.parametrize("kind", ["altitude", "tilt", "downwash"])
def test_a_title_of_a_long_name_is_as_wide_as_the_figure_at_most_and_has_the_quantity(
    flight: Flight, kind: str
) -> None:
    name = "west_" + 90 * "v" + "_2"
    named = replace(flight, names=(name, "cf2"), roll=0.1 * flight.thrust, pitch=flight.thrust)
    figure = plot_quantity(KINDS[kind], [PlotCurve(named, "flight_" + 80 * "n")], name)
    FigureCanvasAgg(figure).draw()
    title = figure.axes[0].title
    extent = title.get_window_extent()
    assert 0.0 <= extent.x0 < extent.x1 <= figure.bbox.width
    assert title.get_text().startswith("west")
    assert f"v_2: {KINDS[kind].title}" in title.get_text()
    assert plot_quantity(KINDS[kind], [PlotCurve(named, "a")], "cf2").axes[0].get_title().startswith("cf2: ")
