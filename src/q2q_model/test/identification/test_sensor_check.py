"""Flights in other units, frames or orders, or of another vehicle, are reported or refused."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from made_flights import GRAVITY, Pass, made_flight

from q2q_model.flights.flight import Flight
from q2q_model.identification.identification import ProcedureParams, identify
from q2q_model.identification.push.recorded_push import push_record
from q2q_model.identification.push.sensor_check import sensor_notes
from q2q_model.identification.statistics.intervals import Interval
from q2q_model.recordings.flight_recording import Recording
from q2q_model.recordings.recording_reader import recording_of_table
from q2q_model.tools.identify_report import summary
from q2q_model.vehicle.altitude_loop import AltitudeLoop
from q2q_model.vehicle.constants import CRAZYFLIE_2_0, CRAZYFLIE_2_1

STIFF = AltitudeLoop(10.0, 5.0, lag=CRAZYFLIE_2_0.thrust_lag)
MADE = Pass(loop=STIFF, start=0.3, noise=1e-4, gust=0.1, seconds=16.0)
UP = np.array([0.0, 0.0, 1.0])


def with_force(flight: Flight, scale: float, offset: float = 0.0) -> Flight:
    """Return the flight with accelerations about g times `scale`, plus `offset` [m/s^2]."""
    force = GRAVITY * UP + scale * (flight.specific_force_body - GRAVITY * UP) + offset * UP
    return replace(flight, specific_force_body=force)


def number(pattern: str, text: str) -> float:
    """Return the number that a pattern finds."""
    found = re.search(pattern, text)
    assert found is not None
    return float(found[1])


def test_a_sound_flight_in_gusts_gives_no_note():
    assert sensor_notes([made_flight(MADE), made_flight(replace(MADE, start=0.0))], CRAZYFLIE_2_0) == []


def test_the_mass_that_the_thrust_carries_is_reported():
    """The flight is one of 34 g; the commands of another vehicle would carry its weight."""
    (note,) = sensor_notes([made_flight(MADE)], CRAZYFLIE_2_1)
    assert "for 2 of 2 vehicles" in note
    assert "crazyflie_2_1 weighs 27.0 g" in note
    assert number(r"carries (\S+) g", note) == pytest.approx(34.0, abs=0.3)  # gusts of 0.1 m/s^2: 1 % of g


def test_a_mass_that_no_vehicle_has_is_told_what_can_be_done() -> None:
    """Commands of 45 g: --vehicle has none, but a scale of the thrust carries 34 g."""
    flight = made_flight(MADE)
    heavy = replace(flight, thrust=45.0 / 34.0 * flight.thrust)
    (note,) = sensor_notes([heavy], CRAZYFLIE_2_0)
    assert "no vehicle of --vehicle has that mass" in note
    scale = number(r"scale thrust by (\S+) ", note)
    assert scale == pytest.approx(34.0 / 45.0, rel=0.01)  # gusts
    assert sensor_notes([replace(heavy, thrust=scale * heavy.thrust)], CRAZYFLIE_2_0) == []
    (named,) = sensor_notes([flight], CRAZYFLIE_2_1)
    assert "(--vehicle, crazyflie_2_0 by that mass)" in named


@pytest.mark.parametrize("offset", [GRAVITY, -GRAVITY])
def test_gravity_counted_twice_or_not_at_all_is_reported(offset: float):
    (note,) = sensor_notes([with_force(made_flight(MADE), 1.0, offset)], CRAZYFLIE_2_0)
    assert number(r"is (\S+) m/s", note) == pytest.approx(offset, abs=0.1)  # the gusts
    assert number(r"the accelerometer reads (\S+) m/s", note) == pytest.approx(GRAVITY + offset, abs=0.1)
    assert "9.81 m/s^2 upwards at rest" in note
    assert not any(word in note for word in ("weighs", "carries", "scale"))  # the mass is right


@pytest.mark.filterwarnings("error")
def test_positions_whose_z_is_down_are_refused_in_a_sentence() -> None:
    """Positions, velocities and references as north, east, down: the commands seem to lead away."""
    flight, turned = made_flight(MADE), np.array([1.0, -1.0, -1.0])
    down = {name: getattr(flight, name) * turned for name in ("mocap_pos", "pos", "vel", "ref_pos")}
    says = r"^no downwash can be inferred from altitudes, as K_p -\d.* K_d -\d.*: check that z is up in"
    with pytest.raises(ValueError, match=says):
        identify([Recording(replace(flight, **down))], ProcedureParams(model_type="jet"), lambda _: None)


def test_accelerations_in_units_of_g_are_told_by_their_slope():
    (note,) = sensor_notes([with_force(made_flight(MADE), 1.0 / GRAVITY)], CRAZYFLIE_2_0)
    assert number(r"slope of (\S+)", note) < 1.0 / GRAVITY < number(r"slope of \S+ to (\S+)", note)


@pytest.mark.parametrize("scale", [1.0, 2.0])
def test_of_vehicles_that_only_hover_no_slope_is_reported(scale: float):
    """Commands vary by a hundredth of the noise: whatever the units, their slope is that of the noise."""
    hover, note = made_flight(Pass(loop=STIFF, noise=1e-6, seconds=16.0)), []
    for seed in range(6):
        noise = 0.1 * np.random.default_rng(seed).standard_normal((*hover.thrust.shape, 1)) * UP
        flight = replace(hover, specific_force_body=hover.specific_force_body + noise)
        note += sensor_notes([with_force(flight, scale)], CRAZYFLIE_2_0)
    assert note == []


def test_the_weight_is_also_reported_where_no_accelerometer_was_recorded():
    flight = made_flight(MADE)
    blind = replace(flight, specific_force_body=np.full_like(flight.specific_force_body, np.nan))
    found = identify([Recording(blind)], ProcedureParams("jet", vehicle=CRAZYFLIE_2_1), lambda _: None)
    (note,) = (one for one in found.remarks if "carries" in one)
    assert note.startswith("the commanded thrust carries 34.0 g, and crazyflie_2_1 weighs 27.0 g")


def test_a_flight_that_is_not_upright_is_refused_by_every_step():
    flight = made_flight(MADE)
    w_first = replace(flight, quat=np.roll(flight.quat, 1, axis=-1))
    for step in (
        lambda: identify([Recording(w_first)], ProcedureParams("jet"), lambda _: None),
        lambda: push_record(Recording(w_first), CRAZYFLIE_2_0, 0.07),
    ):
        with pytest.raises(ValueError, match=r"cf1 points -1.00 upwards in the median.* order x y z w"):
            step()


def test_gains_that_lead_away_from_the_reference_are_not_written():
    flight = made_flight(MADE)
    turned = replace(flight, thrust=2.0 * CRAZYFLIE_2_0.hover_thrust - flight.thrust)
    found = identify([Recording(turned)], ProcedureParams("jet"), lambda _: None)
    assert found.file.gains is None
    assert any("the model file has no gains, as K_p -10 and K_d -5" in remark for remark in found.remarks)
    note = summary(found)
    assert note.count(": negative, the commands lead away from the reference") == 2
    assert "not identifiable" not in note
    assert re.search(r"^K_p -10\.\d+ 1/s\^2 \[-\d.*^K_d -5\.\d+ 1/s \[-\d", note, re.MULTILINE | re.DOTALL)


def test_the_parameters_of_a_jet_are_reported_with_their_units():
    fitted = [(name, Interval(0.5, 0.4, 0.6)) for name in ("strength", "spread", "upper_ratio", "slowness")]
    found = identify([Recording(made_flight(MADE))], ProcedureParams("jet"), lambda _: None)
    note = summary(replace(found, spread=tuple(fitted)))
    for words in ("strength 0.500 m/s^2", "spread 0.500 m/m", "upper_ratio 0.500", "slowness 0.500 s/m"):
        assert f"\n  {words} [0.400, 0.600]" in note


@pytest.mark.parametrize("filtered", [True, False])
def test_velocities_that_are_filtered_poses_are_reported(filtered: bool, tmp_path: Path):
    flight = made_flight(MADE)
    columns = {"t": flight.t}
    for axis, name in enumerate("xyz"):
        columns |= {f"cf1_{name}": flight.pos[:, 0, axis], f"cf1_{name}ref": flight.ref_pos[:, 0, axis]}
        columns |= {} if filtered else {f"cf1_v{name}": flight.vel[:, 0, axis]}
    columns |= {f"cf1_q{name}": flight.quat[:, 0, k] for k, name in enumerate("xyzw")}
    columns |= {f"cf1_w{name}": np.zeros(flight.t.size) for name in "pqr"}
    columns["cf1_thrust_cmd"] = flight.thrust[:, 0]
    table = tmp_path / "flight.csv"
    np.savetxt(
        table, np.stack(list(columns.values()), axis=1), delimiter=",", header=",".join(columns), comments=""
    )
    found = identify([recording_of_table(table)], ProcedureParams("jet"), lambda _: None)
    note = [one for one in found.remarks if "record the topic state" in one]
    assert len(note) == int(filtered)
    assert (abs(found.gains.k_d.value - STIFF.k_d) < 0.1) is not filtered
