"""A flight validates in its own air and not in another one."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from turbulent_passes import air, recorded_passes

from q2q_model.vehicle.constants import CRAZYFLIE_2_0
from q2q_sim.air.air_terms import RotorDragTerm, VehicleTerm
from q2q_sim.air.room_air import RoomAir
from q2q_sim.experiments.validation.drawn_air import draws_in
from q2q_sim.experiments.validation.error_figures import error_figure
from q2q_sim.experiments.validation.error_statistics import comparison
from q2q_sim.experiments.validation.recorded.tracked_flight import TrackedFlight
from q2q_sim.experiments.validation.validate_flights import _all_flown
from q2q_sim.experiments.validation.validated_flight import (
    COVERAGE,
    RMS_RATIO,
    ValidatedFlight,
    as_json,
    pooled_comparison,
    validate_flight,
    validation_sentence,
)
from q2q_sim.experiments.validation.validation_page import write_page
from q2q_sim.experiments.validation.validation_replay import longest_under_wake, replayed_runs
from q2q_sim.plant.body.state_row import VEL


@pytest.fixture(scope="module")
def flight() -> TrackedFlight:
    """Return a flight in the air of strength 1."""
    return recorded_passes()


@pytest.fixture(scope="module")
def own(flight: TrackedFlight) -> ValidatedFlight:
    """Return the flight flown again in its own air."""
    return validate_flight(flight, CRAZYFLIE_2_0, air(1.0))


def test_a_flight_validates_in_its_own_air(own: ValidatedFlight) -> None:
    found = pooled_comparison([own])
    assert found.n > 200
    assert found.z_rms_ratio == pytest.approx(1.0, abs=0.15)
    assert found.correlation == pytest.approx(1.0, abs=0.1)
    assert found.coverage95 == pytest.approx(0.95, abs=0.05)
    assert comparison(own.clear).coverage95 == pytest.approx(0.95, abs=0.05)


def test_a_flight_does_not_validate_in_an_air_twice_as_strong(flight: TrackedFlight) -> None:
    found = pooled_comparison([validate_flight(flight, CRAZYFLIE_2_0, air(2.0), range(8))])
    assert found.z_rms_ratio is not None
    assert found.coverage95 is not None
    assert found.z_rms_ratio > RMS_RATIO[1]
    assert found.coverage95 < COVERAGE[0]
    assert "times the recorded" in validation_sentence(found)


def test_a_flight_without_a_wake_has_clear_air_only(own: ValidatedFlight) -> None:
    alone = replace(own, under=tuple(replace(part, n=0) for part in own.under))
    text = as_json([alone], in_fit=("room/" + alone.flight.name,))
    assert text["flights"][alone.flight.name]["in_fit"]
    assert not as_json([alone], in_fit=("another",))["flights"][alone.flight.name]["in_fit"]
    assert text["pooled"] == {
        "z_rms_ratio": None,
        "correlation": None,
        "spectrum_db": None,
        "coverage95": None,
        "worst_ratio": None,
        "n": 0,
        "z_rms_recorded_m": None,
    }
    assert str(text["verdict"]).startswith("No row under another vehicle was compared")


def test_notes_are_on_the_page_and_in_the_numbers(own: ValidatedFlight, tmp_path: Path) -> None:
    note = f"{own.flight.name}: a flight of this name is in the fit"
    assert as_json([own], notes=[note])["notes"] == [note]
    assert note in write_page([own], [], "room", tmp_path, [note]).read_text(encoding="utf-8")


def test_a_flight_whose_law_cannot_be_read_is_left_out_and_the_others_are_compared(
    flight: TrackedFlight, capsys: pytest.CaptureFixture[str]
) -> None:
    mute = replace(flight, name="mute", thrust=np.full_like(flight.thrust, np.nan))
    done = _all_flown([mute, flight], RoomAir(), CRAZYFLIE_2_0, 3)
    assert [one.flight.name for one in done] == [flight.name]
    assert "validate: left out: flight mute cannot be flown again" in capsys.readouterr().err


def test_a_vehicle_under_another_with_little_clear_air_is_named(
    flight: TrackedFlight, capsys: pytest.CaptureFixture[str]
) -> None:
    _all_flown(
        [replace(flight, name="short", scored=np.zeros(2, dtype=np.bool_))], RoomAir(), CRAZYFLIE_2_0, 2
    )
    notes = capsys.readouterr().err
    assert "short: cf1 is not compared, as it has fewer than 200 rows in clear air" in notes
    assert "short: only clear air is compared" in notes
    assert "cf2" not in notes  # never under another
    assert "no row under another vehicle" not in notes


def test_a_draw_has_the_recorded_headroom_of_each_vehicle_and_no_second_drag(flight: TrackedFlight) -> None:
    own = VehicleTerm(0.0, 0.0, 0.07, 1.9, 0.0, 0.0, headroom_std=0.2)
    room = RoomAir(vehicle=own, rotor_drag=RotorDragTerm(0.4))
    recorded_too = replace(flight, headroom=np.array([[1.5, 1.4, 1.6, 1.5], [1.8, 1.9, 1.7, 1.8]]))
    apart = np.array([[0.0, 0.0, 1.0, 0.0], [1.0, 0.0, 1.0, 0.0]])
    swarm = draws_in(room, recorded_too, CRAZYFLIE_2_0)(3, apart).swarm
    headroom = 4.0 * swarm.air.room.rotor_max / CRAZYFLIE_2_0.hover_thrust
    np.testing.assert_allclose(headroom, recorded_too.headroom)
    swarm.state[:, VEL] = [1.0, 0.0, 0.0]
    assert not swarm.downwash().any()  # redrawn_flight adds the drag that the flight shows


def test_the_replay_shows_the_recording_beside_its_first_draw(own: ValidatedFlight) -> None:
    recorded, simulated = replayed_runs(own)
    np.testing.assert_array_equal(recorded.pos, own.flight.pos)
    height_error = simulated.pos[..., 2] - simulated.ref_pos[..., 2]
    np.testing.assert_array_equal(height_error, own.drawn[0])
    assert longest_under_wake([own]) is own


def test_the_figure_of_a_flight_has_no_empty_panel(own: ValidatedFlight) -> None:
    panels = error_figure(own).axes
    assert len(panels) == 1  # cf2 is never under another vehicle
    assert [len(line.get_ydata()) for line in panels[0].lines] == [len(own.flight.t)] * 2
