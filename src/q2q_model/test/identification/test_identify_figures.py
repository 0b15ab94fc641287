"""Figures of an identification show what was flown, and no downwash where the model has none."""

from dataclasses import replace

import pytest
from identification_passes import FLOWN
from made_flights import LOOP, made_flight

from q2q_model.downwash.no_interaction import NoInteraction
from q2q_model.flights.flight import of_vehicle
from q2q_model.identification import identification
from q2q_model.identification.deviation import DecayFit, Overlap
from q2q_model.identification.gains.altitude_from_flight import altitude_record
from q2q_model.identification.identification import Identification, ProcedureParams, identify
from q2q_model.identification.statistics.intervals import Interval
from q2q_model.recordings.flight_recording import Recording
from q2q_model.tools.identify_figures import _altitude_figure, _figures
from q2q_model.vehicle.constants import CRAZYFLIE_2_0


@pytest.fixture(scope="module")
def found() -> Identification:
    """Return what is identified from passes."""
    recordings = [Recording(made_flight(one)) for one in FLOWN]
    return identify(recordings, ProcedureParams(model_type="jet"), lambda _: None)


def test_a_model_without_downwash_has_no_figure_of_it(found: Identification) -> None:
    assert "fig8_9_downwash" in _figures(found)
    none = replace(found, file=replace(found.file, interaction=NoInteraction()))
    assert set(_figures(found)) - set(_figures(none)) == {"fig8_9_downwash"}


def test_only_one_of_several_vehicles_has_a_role() -> None:
    flight = made_flight(FLOWN[0])
    labels = []
    for one in (flight, of_vehicle(flight, flight.names[0])):
        drawn = _altitude_figure(altitude_record(one, CRAZYFLIE_2_0), LOOP, None, "loop")
        labels.append([axes.get_ylabel() for axes in drawn.axes])
    name, other = flight.names
    assert sorted(labels[0]) == sorted([f"{name} (lower): z [m]", f"{other} (upper): z [m]"])
    assert labels[1] == [f"{name}: z [m]"]


def test_the_gap_that_the_decay_ends_at_is_not_called_the_largest_flown(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """That of the learned zone is: an average over an overlap is smaller."""
    overlaps = Overlap("near", 0.5, 0.1, 3.0), Overlap("far", 0.98, 0.05, 3.0)
    one = Interval(1.0, 0.5, 1.5)
    decay = DecayFit(overlaps, one, one, Interval(1.4, 1.2, 1.6), extrapolated=True)
    monkeypatch.setattr(identification, "fit_decay", lambda _: decay)
    said = ["d = 1.40 m is beyond the largest average gap, 0.98 m: it is extrapolated"]
    assert identification._decay([]) == (decay, said)
