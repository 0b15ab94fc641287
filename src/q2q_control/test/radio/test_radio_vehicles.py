"""Vehicles of the node `radio`: how long its end waits for their landing."""

from collections.abc import Callable

import pytest
from radio_pilot_bench import LANDING_S, NAMES, PARAMS, FakeLink, state

from q2q_control.flight_procedure.procedure_params import FlightProcedureParams, LandingParams
from q2q_control.flight_procedure.steps import Act, Order
from q2q_control.radio import radio_vehicles
from q2q_control.radio.pilot.vehicle_record import Phase
from q2q_control.radio.radio_params import RadioNodeParams
from q2q_control.radio.radio_vehicles import SETTLE_S, RadioVehicles
from q2q_model.diagnostics.health import Health


def in_flight(
    monkeypatch: pytest.MonkeyPatch,
    ground_height: float = 0.0,
    open_one: Callable[..., FakeLink] = lambda *_, **__: FakeLink(),
) -> RadioVehicles:
    """Return vehicles that fly at z = 3 m and 6 m at t = 0 s."""
    monkeypatch.setattr(radio_vehicles, "CflibLink", open_one)
    params = RadioNodeParams(vehicles=NAMES, uris=("udp://127.0.0.1:1", "udp://127.0.0.1:2"))
    procedure = FlightProcedureParams(ground_height=ground_height), LandingParams()
    vehicles = RadioVehicles(params, PARAMS, procedure, Health())
    pilot = vehicles.pilot
    pilot.watch(0.0)
    pilot.update_state(state(0.0), 0.0)
    for act in (Act.ARM, Act.STREAM):
        pilot.begin(Order(act), 0.0)
        pilot.watch(0.0)
    assert set(pilot.phases.values()) == {Phase.FLYING}
    return vehicles


def test_links_that_were_opened_are_closed_where_a_later_one_is_refused(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    opened: list[FakeLink] = []

    def open_one(name: str, *_: object, **__: object) -> FakeLink:
        if name == NAMES[1]:
            raise ValueError("udp://127.0.0.1:2 is in use")
        opened.append(FakeLink())
        return opened[-1]

    with pytest.raises(ValueError, match="in use"):
        in_flight(monkeypatch, open_one=open_one)
    assert [link.sent for link in opened] == [["close"]]


def test_an_end_in_flight_waits_for_the_longest_landing(monkeypatch: pytest.MonkeyPatch) -> None:
    assert in_flight(monkeypatch).land(0.0) == LANDING_S[1] + SETTLE_S


def test_an_end_in_flight_lands_to_the_ground_of_the_procedure(monkeypatch: pytest.MonkeyPatch) -> None:
    vehicles = in_flight(monkeypatch, ground_height=2.0)
    assert vehicles.land(0.0) == (6.0 - 2.0) / 0.4 + SETTLE_S
    for link, height in zip(vehicles.links.values(), (3.0, 6.0), strict=True):
        assert isinstance(link, FakeLink)
        assert link.sent[-1] == ("land", 2.0, max(3.0, (height - 2.0) / 0.4))


def test_an_end_during_a_landing_waits_for_the_rest_of_it(monkeypatch: pytest.MonkeyPatch) -> None:
    vehicles = in_flight(monkeypatch)
    vehicles.pilot.begin(Order(Act.LAND), 0.0)
    vehicles.pilot.watch(4.0)
    assert vehicles.land(4.0) == LANDING_S[1] - 4.0 + SETTLE_S
    assert vehicles.land(LANDING_S[1] + 5.0) == SETTLE_S  # over, and not watched since
    vehicles.pilot.watch(LANDING_S[1] + 5.0)
    assert vehicles.land(LANDING_S[1] + 5.0) == 0.0


def test_an_end_waits_for_the_vehicle_that_still_lands_when_others_are_down(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    vehicles = in_flight(monkeypatch)
    vehicles.pilot.begin(Order(Act.LAND), 0.0)
    vehicles.pilot.watch(LANDING_S[0] + 0.1)
    assert vehicles.pilot.phases == {"cf1": Phase.READY, "cf2": Phase.LANDING}
    left = LANDING_S[1] - LANDING_S[0] - 0.1
    assert vehicles.land(LANDING_S[0] + 0.1) == pytest.approx(left + SETTLE_S, abs=1e-9)  # rounding
