"""Tests of the figures of a flight on flights made by hand."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from q2q_model.documents.json_file import write_json
from q2q_model.flights.flight import Flight, of_rows
from q2q_model.geometry.zone import Cylinder
from q2q_sim.loop.flight_recorder import FlightRecorder
from q2q_sim.monitors.flight_verdict import FlightVerdict
from q2q_sim.monitors.metrics.exposure import exposed, exposure
from q2q_sim.monitors.metrics.flight_metrics import held_thrust, measure
from q2q_sim.node_flights.flight_request import FlightRequest
from q2q_sim.node_flights.flight_run import FlightRun, runs_json
from q2q_sim.report.bag_tables import TRACKING
from q2q_sim.report.run_table import HEAD as TERMINAL_HEAD
from q2q_sim.scenarios import library
from q2q_sim.simulator.flight_clock import FlightTiming

T = np.arange(1000) * 0.01
SCENARIO = library.load("table6")


def _flight(pos: np.ndarray, ref: np.ndarray, thrust: np.ndarray) -> Flight:
    empty = FlightRecorder(("cf1", "cf2")[: pos.shape[1]], len(T)).flight("made by hand")
    return replace(empty, t=T, true_pos=pos, ref_pos=ref, thrust=thrust)


def _still(n: int = 2) -> np.ndarray:
    return np.tile(np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 1.5]])[:n], (len(T), 1, 1))


def test_errors_are_root_mean_squares_along_z_and_beside_it() -> None:
    ref = _still()
    off = np.stack([0.3 * np.sin(2 * np.pi * T), 0.4 * np.sin(2 * np.pi * T), np.full(len(T), -0.2)], axis=1)
    pos = ref + np.stack([off, 0.0 * off], axis=1)
    one, two = measure(_flight(pos, ref, np.ones((1000, 2))), SCENARIO.vehicle).vehicles.values()
    assert one.z_rmse_m == pytest.approx(0.2, rel=1e-12)
    assert one.xy_rmse_m == pytest.approx(0.5 / np.sqrt(2.0), rel=1e-12)  # ten whole periods
    assert (two.z_rmse_m, two.xy_rmse_m) == (0.0, 0.0)


def test_errors_that_are_not_recorded_do_not_count_and_infinite_ones_do() -> None:
    ref = _still()
    pos = ref + np.array([0.0, 0.0, 0.2])
    ref[700, :, 2] = np.nan
    lacking = measure(_flight(pos, ref, np.ones((1000, 2))), SCENARIO.vehicle).vehicles["cf1"]
    assert (lacking.z_rmse_m, lacking.worst_m) == pytest.approx((0.2, 0.2), rel=1e-12)
    ref[701, 0, 2] = np.inf
    one, two = measure(_flight(pos, ref, np.ones((1000, 2))), SCENARIO.vehicle).vehicles.values()
    assert (one.z_rmse_m, one.under_rms_m, one.worst_m) == (np.inf, np.inf, np.inf)
    assert two.z_rmse_m == pytest.approx(0.2, rel=1e-12)


def test_tables_call_the_integral_of_squared_thrust_by_its_name_in_control() -> None:
    assert TERMINAL_HEAD[4:6] == ("control\neffort\n[N²s]", "above\nhover\n[N²s]")
    assert TRACKING["u1_energy"] == "control effort ∫ U1² dt [N²s]"


def test_control_effort_of_hover_is_its_square_over_time() -> None:
    weight = SCENARIO.vehicle.hover_thrust
    thrust = np.column_stack([np.full(1000, weight), weight + np.sin(2 * np.pi * T)])
    one, two = measure(_flight(_still(), _still(), thrust), SCENARIO.vehicle).vehicles.values()
    assert one.u1_energy == pytest.approx(weight**2 * 10.0, rel=1e-12)
    assert one.u1_energy_above_hover == pytest.approx(0.0, abs=1e-9)
    assert two.u1_energy_above_hover == pytest.approx(5.0, rel=1e-9)  # the mean square of a sine over 10 s
    assert two.u1_max == pytest.approx(weight + 1.0, rel=1e-3)


def test_control_effort_counts_the_ticks_whose_rows_are_lost() -> None:
    """A tick without a row holds the last command, as one without a command does."""
    weight, kept = SCENARIO.vehicle.hover_thrust, (T < 2.0) | (T >= 5.0)
    whole = _flight(_still(1), _still(1), np.full((1000, 1), 1.1 * weight))
    found = measure(of_rows(whole, kept), SCENARIO.vehicle).vehicles["cf1"]
    assert found.u1_energy == pytest.approx(1.21 * weight**2 * 10.0, rel=1e-12)
    assert found.u1_energy_above_hover == pytest.approx(0.21 * weight**2 * 10.0, rel=1e-9)


def test_separation_and_zone_time_are_those_of_the_closest_pair() -> None:
    pos = _still()
    pos[:, 1, 1] = np.where((T >= 2.0) & (T < 5.0), 0.05, 2.0)
    found = measure(_flight(pos, pos, np.ones((1000, 2))), SCENARIO.vehicle, Cylinder(eps=0.1, d=1.1))
    assert found.min_separation_m == pytest.approx(np.hypot(0.5, 0.05), rel=1e-12)
    assert found.zone_time_s == pytest.approx(3.0, rel=1e-12)
    assert (
        measure(_flight(pos, pos, np.ones((1000, 2))), SCENARIO.vehicle, Cylinder(0.1, 0.4)).zone_time_s
        == 0.0
    )


def test_what_a_flight_lacks_is_nan() -> None:
    alone = measure(_flight(_still(1), _still(1), np.full((1000, 1), np.nan)), SCENARIO.vehicle)
    assert np.isnan([alone.min_separation_m, alone.zone_time_s]).all()
    assert np.isnan([alone.vehicles["cf1"].u1_energy, alone.vehicles["cf1"].u1_max]).all()
    assert alone.vehicles["cf1"].z_rmse_m == 0.0


def test_a_pair_without_positions_has_no_time_in_the_zone() -> None:
    nowhere = np.full_like(_still(), np.nan)
    found = measure(_flight(nowhere, nowhere, np.full((len(T), 2), np.nan)), SCENARIO.vehicle)
    assert np.isnan(found.min_separation_m)
    assert np.isnan(found.zone_time_s)


def test_filtered_positions_count_from_the_first_sample_of_a_vehicle_on() -> None:
    ref = _still() + np.array([0.0, 0.5, 0.0]) * np.arange(2)[:, None]  # cf2 is 0.5 m above and beside cf1
    late = np.arange(2) * (T[:, None] < 0.8)  # cf2 is seen from 0.8 s on
    filtered = np.where(late[..., None], 0.0, ref)
    flight = replace(_flight(np.full_like(ref, np.nan), ref, np.ones((1000, 2))), pos=filtered)
    seen = measure(replace(flight, mocap_pos=np.where(late[..., None], np.nan, ref)), SCENARIO.vehicle)
    assert seen.min_separation_m == pytest.approx(np.hypot(0.5, 0.5), rel=1e-12)
    assert (seen.zone_time_s, seen.vehicles["cf2"].z_rmse_m) == (0.0, 0.0)


def test_filtered_positions_serve_where_the_truth_is_unknown() -> None:
    flight = _flight(np.full((1000, 1, 3), np.nan), _still(1), np.ones((1000, 1)))
    seen = replace(flight, pos=_still(1) + np.array([0.0, 0.0, 0.1]))
    assert measure(seen, SCENARIO.vehicle).vehicles["cf1"].z_rmse_m == pytest.approx(0.1, rel=1e-12)


def test_a_tick_without_a_command_obeys_the_last_one_and_none_is_made_up_before_the_first() -> None:
    np.testing.assert_array_equal(
        held_thrust(np.array([np.nan, 2.0, np.nan, np.nan, 3.0])), [2.0, 2.0, 2.0, 3.0]
    )
    assert held_thrust(np.full(3, np.nan)).size == 0


def test_a_vehicle_is_exposed_below_another_and_for_a_while_after() -> None:
    pos = np.zeros((300, 2, 3))
    pos[:, 1] = [1.0, 0.0, 0.5]
    pos[50:100, 1, 0] = 0.1
    found = exposed(pos, T[:300], 1.0)
    assert not found[:, 1].any()
    assert np.array_equal(np.flatnonzero(found[:, 0]), np.arange(50, 200))  # 100 ticks after the last below


def test_height_errors_are_told_apart_by_where_the_other_vehicle_is() -> None:
    ref = _still()
    ref[:, 1, 0] = np.where((T >= 5.0) & (T < 6.0), 0.0, 2.0)  # over the lower vehicle for a second
    error = np.select([T < 3.0, T < 5.0, T < 7.0], [9.0, 0.01, 0.02], 5.0)  # settling; clear; under; neither
    error[550] = -0.1
    pos = ref.copy()
    pos[:, 0, 2] += error
    lower, upper = measure(_flight(pos, ref, np.ones((1000, 2))), SCENARIO.vehicle).vehicles.values()
    assert lower.clear_rms_m == pytest.approx(np.sqrt((200 * 0.01**2 + 100 * 5.0**2) / 300))
    assert lower.under_rms_m == pytest.approx(np.sqrt((199 * 0.02**2 + 0.1**2) / 200))
    assert lower.worst_m == pytest.approx(0.1, rel=1e-12)
    assert np.isnan([upper.under_rms_m, upper.worst_m]).all()
    assert upper.clear_rms_m == 0.0


def test_air_is_clear_only_while_the_positions_of_all_others_are_known() -> None:
    ref = _still()
    ref[:, 1, 0] = 2.0
    pos = ref.copy()
    pos[(T >= 4.0) & (T < 5.0), 1] = np.nan  # clear from 3 to 4 s and from 8 s on
    pos[:, 0, 2] += np.where((T >= 4.0) & (T < 7.985), 0.3, 0.01)
    lower, upper = measure(_flight(pos, ref, np.ones((1000, 2))), SCENARIO.vehicle).vehicles.values()
    assert lower.clear_rms_m == pytest.approx(0.01, rel=1e-9)
    assert upper.clear_rms_m == 0.0


def test_exposure_lasts_as_long_where_ticks_are_missing() -> None:
    pos = np.tile([[0.0, 0.0, 1.0], [2.0, 0.0, 1.5]], (len(T), 1, 1))
    pos[(T >= 3.5) & (T < 4.0), 1, 0] = 0.0
    kept = (T < 4.2) | (T >= 4.8)
    whole, part = exposure(pos, T), exposure(pos[kept], T[kept])
    assert np.array_equal(part.under, whole.under[kept])
    assert np.array_equal(part.clear, whole.clear[kept])


def test_null_stands_for_errors_that_a_flight_does_not_show(tmp_path: Path) -> None:
    run = FlightRun(
        FlightRequest("table6"),
        _flight(_still(1), _still(1), np.ones((1000, 1))),
        measure(_flight(_still(1), _still(1), np.ones((1000, 1))), SCENARIO.vehicle),
        FlightTiming(0, 0, None, None, None),
        Path("bag"),
        FlightVerdict(10.0),
    )
    write_json(runs_json([run]), tmp_path / "runs.json")
    one = json.loads((tmp_path / "runs.json").read_text())["runs"][0]["vehicles"]["cf1"]
    assert (one["under_rms_m"], one["clear_rms_m"], one["worst_m"]) == (None, 0.0, None)
