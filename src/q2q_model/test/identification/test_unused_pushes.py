"""What identification says of pushes that it does not use, and of a strength that it cannot know then."""

from dataclasses import replace

import numpy as np
import pytest
from made_flights import LOOP, PASSES, Pass, made_flight, record_of

from q2q_model.flights.flight import Flight
from q2q_model.identification.identification import Identification, ProcedureParams, identify
from q2q_model.identification.jet.jet_form import FREE_PARAMETERS
from q2q_model.identification.push.along_flight import Motion
from q2q_model.identification.push.push_samples import PushRecord, push_samples
from q2q_model.identification.selection.identification_data import IdentificationData
from q2q_model.identification.selection.unused_pushes import unused_push_notes
from q2q_model.recordings.flight_recording import Recording
from q2q_model.vehicle.constants import CRAZYFLIE_2_0

GAPS = (0.4, 0.5)
PARAMS = ProcedureParams(model_type="jet", vehicle=replace(CRAZYFLIE_2_0, thrust_lag=LOOP.lag))


def identified(flights: list[Flight]) -> Identification:
    """Return what flights show."""
    return identify([Recording(one) for one in flights], PARAMS, lambda _: None)


def passes(speed: float) -> list[Flight]:
    """Return passes at a speed [m/s]."""
    made = [Pass(name=f"gap {gap}", gap=gap, speed=speed, seconds=24.0, noise=1e-4) for gap in GAPS]
    return [made_flight(one) for one in made]


def strength_is_any(found: Identification) -> bool:
    """Return whether the interval of the strength is the range of its search."""
    span, allowed = dict(found.spread)["strength"], FREE_PARAMETERS["strength"]
    return (span.low, span.high) == (allowed.low, allowed.high)


def test_pushes_in_clear_air_are_used_without_a_note() -> None:
    found = identified(passes(0.3))
    assert found.train.r2_of == "downwash"
    assert not any("inferred" in one or "not used" in one for one in found.remarks)
    assert any("from imu and command" in one for one in found.remarks)
    assert not strength_is_any(found)


def test_vehicles_that_never_part_leave_the_strength_unknown() -> None:
    """The upper one stays within 0.24 m of the other's axis: nothing tells an offset from downwash."""
    found = identified(passes(0.02))
    assert found.train.r2_of == "altitude deviation"
    (note,) = [one for one in found.remarks if "inferred" in one]
    assert note.startswith(
        "gap 0.4, gap 0.5: downwash is inferred from altitudes: cf1 has fewer than 200 measured rows in clear"
    )
    assert "the constant of cf1 is unknown" in note
    assert not any("from imu and command" in one for one in found.remarks)
    assert note.endswith("whose strength is unknown: do not use the model for compensation")
    assert strength_is_any(found)


def test_only_the_vehicle_without_clear_air_is_named_where_another_of_its_flight_is_used() -> None:
    """A third vehicle accompanies the upper one, 0.4 m below it."""
    record = record_of(PASSES[0])
    pos, still = (np.concatenate([one, one[:, 1:]], axis=1) for one in (record.pos, 0.0 * record.vel))
    pos[:, 2, 2] -= 0.4
    motion, none = Motion(record.t, pos, still, still + np.array([0.0, 0.0, 1.0])), np.zeros(pos.shape[:2])
    push = PushRecord(record.name, ("cf1", "cf2", "cf3"), motion, none, none == 0.0, none > 0.0)
    data = IdentificationData((record,), tuple(push_samples(push)))
    assert 0 in [one.vehicle for one in data.pushes if one.exposed.any()]
    (note,) = unused_push_notes([push], [data], None)
    assert note.startswith("gap 0.4: the push on cf3 is not used: cf3 has fewer than 200 measured rows in")


@pytest.mark.parametrize(
    ("vehicles", "reason"),
    [(slice(None), "no push was measured"), (slice(1), "nothing was measured of the vehicle below")],
)
def test_flights_without_accelerometers_say_that_nothing_was_measured(vehicles: slice, reason: str) -> None:
    """In passes with clear air the altitudes show the constant, and so the strength."""
    found = identified([blind(one, vehicles) for one in passes(0.3)])
    (note,) = [one for one in found.remarks if "inferred" in one]
    assert reason in note
    assert "unknown" not in note
    assert not strength_is_any(found)


def blind(flight: Flight, vehicles: slice) -> Flight:
    """Return a flight without the accelerometers of some vehicles."""
    felt = flight.specific_force_body.copy()
    felt[:, vehicles] = np.nan
    return replace(flight, specific_force_body=felt)
