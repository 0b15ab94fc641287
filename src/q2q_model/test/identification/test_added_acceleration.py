"""What a controller commands in addition to its loop is no downwash, and downwash that it compensates is."""

from dataclasses import replace

import numpy as np
import pytest
from made_flights import Pass, made_flight

from q2q_model.downwash.interaction_model import pairs_at_rest
from q2q_model.downwash.jet import PAPER_LAW
from q2q_model.flights.flight import Flight
from q2q_model.flights.flight_log import FlightLog
from q2q_model.identification.gains.altitude_from_flight import altitude_record
from q2q_model.identification.gains.altitude_record import in_clear_air
from q2q_model.identification.gains.command_gains import gains_from_commands
from q2q_model.identification.gains.impulse_response import CLEAR, with_added_acc
from q2q_model.identification.identification import ProcedureParams, identify
from q2q_model.identification.jet.jet_fit import fit_to_altitudes
from q2q_model.identification.jet.jet_form import JetForm
from q2q_model.identification.recorded_altitudes import FEED_FORWARD, recorded_altitudes
from q2q_model.identification.selection.cross_validation import score_on
from q2q_model.identification.selection.identification_data import IdentificationData
from q2q_model.recordings.flight_recording import Recording
from q2q_model.signals.values import Array
from q2q_model.vehicle.altitude_loop import AltitudeLoop
from q2q_model.vehicle.constants import CRAZYFLIE_2_0

TIGHT = AltitudeLoop(k_p=5.0, k_d=3.0)
NOISE = 1e-4
"""[m]"""
GAPS = (0.35, 0.5, 0.7)
UNDER = np.array([[0.0, 0.0, 0.5]])
NO_LAG = replace(CRAZYFLIE_2_0, thrust_lag=0.0)


def passes(loop: AltitudeLoop = TIGHT, left: float = 1.0) -> list[Flight]:
    """Return flights in which `left` of the paper's downwash acts."""
    law = replace(PAPER_LAW, strength=left * PAPER_LAW.strength)
    made = [Pass(f"gap {gap}", gap, loop=loop, law=law, noise=NOISE, seconds=20.0) for gap in GAPS]
    return [made_flight(one) for one in made]


def trimmed(flight: Flight, acc: float) -> Flight:
    """Return the flight with `acc` [m/s^2] commanded in addition, which no vehicle feels."""
    return replace(flight, thrust=flight.thrust + CRAZYFLIE_2_0.mass * acc)


def fed_forward(flight: Flight, share: float) -> Flight:
    """Return the flight as that of a controller that has compensated `share` of the downwash."""
    whole = flight.true_eta / (1.0 - share)
    thrust = flight.thrust - CRAZYFLIE_2_0.mass * share * whole[..., 2]
    return replace(flight, thrust=thrust, eta=whole)


def constants(flights: list[Flight], loop: AltitudeLoop = TIGHT) -> Array:
    records = [altitude_record(one, CRAZYFLIE_2_0) for one in flights]
    return np.stack([with_added_acc(one, loop, 0.0).added_acc[0] for one in records])


def test_a_trim_that_balances_a_weak_battery_pushes_nobody() -> None:
    flights = [trimmed(one, 0.2) for one in passes()]
    found = gains_from_commands([altitude_record(one, CRAZYFLIE_2_0) for one in flights])
    assert found.loop.offset == pytest.approx(0.2, abs=0.01)
    np.testing.assert_allclose(constants(flights), 0.0, atol=0.005)


def test_a_constant_that_nothing_balances_is_found_in_clear_air() -> None:
    pushed = replace(TIGHT, offset=0.15)
    np.testing.assert_allclose(constants(passes(pushed)), 0.15, atol=0.005)


def test_a_vehicle_that_is_never_alone_counts_as_balanced() -> None:
    flight = passes(replace(TIGHT, offset=0.15))[0]
    near = np.where(np.arange(3) == 1, 0.2 * flight.pos, flight.pos)  # y within 0.2 m
    record = altitude_record(replace(flight, pos=near, mocap_pos=near), CRAZYFLIE_2_0)
    assert not in_clear_air(record, CLEAR).any()
    assert (with_added_acc(record, TIGHT, 0.0).added_acc == 0.0).all()


def test_altitudes_of_an_aware_controller_teach_the_whole_downwash() -> None:
    share = 0.8
    records = [altitude_record(fed_forward(one, share), CRAZYFLIE_2_0) for one in passes(left=1.0 - share)]
    gains = gains_from_commands(records)
    assert all(one == pytest.approx(share, abs=0.02) for one in gains.compensated.values())
    known = [with_added_acc(one, TIGHT, gains.compensated[one.name]) for one in records]
    jet = fit_to_altitudes(known, TIGHT, JetForm()).jet
    truth = PAPER_LAW.acceleration(UNDER, pairs_at_rest(UNDER))[0, 2]
    assert jet.acceleration(UNDER, pairs_at_rest(UNDER))[0, 2] == pytest.approx(truth, rel=0.05)
    errors = [
        score_on(PAPER_LAW, [IdentificationData((one,), ()) for one in each], TIGHT).mse_m2.lower
        for each in (known, records)
    ]
    assert errors[0] < 0.01 * errors[1]


def test_flights_that_compensate_and_flights_that_do_not_give_one_loop() -> None:
    made = passes(left=0.2)
    aware, ignoring = fed_forward(made[0], 0.8), replace(made[1], eta=made[1].true_eta / 0.2)
    gains = gains_from_commands([altitude_record(one, CRAZYFLIE_2_0) for one in (ignoring, aware)])
    assert gains.k_p.value == pytest.approx(TIGHT.k_p, rel=1e-6)  # commands are those of the law, exactly
    assert gains.k_d.value == pytest.approx(TIGHT.k_d, rel=1e-6)
    assert gains.k_p.low <= TIGHT.k_p * (1.0 + 1e-6)
    assert gains.k_p.high < TIGHT.k_p * 1.001
    assert gains.compensated[aware.name] == pytest.approx(0.8, abs=1e-6)
    assert gains.compensated[ignoring.name] == pytest.approx(0.0, abs=1e-6)


def test_identify_takes_away_what_the_controller_adds() -> None:
    aware = [trimmed(fed_forward(one, 0.8), 0.2) for one in passes(left=0.2)]
    quiet = [replace(one, specific_force_body=np.full_like(one.pos, np.nan)) for one in aware]
    params = ProcedureParams(model_type="jet", vehicle=NO_LAG)
    found = identify([Recording(one) for one in quiet], params, lambda _: None).file
    truth = PAPER_LAW.acceleration(UNDER, pairs_at_rest(UNDER))[0, 2]
    assert found.interaction.acceleration(UNDER, pairs_at_rest(UNDER))[0, 2] == pytest.approx(truth, rel=0.1)
    assert found.gains is not None
    assert found.gains.offset == 0.0


def test_an_empty_log_leaves_the_downwash_that_the_flight_has_as_compensated() -> None:
    flight = fed_forward(passes()[0], 0.5)
    unknown = np.full((flight.t.size, 2, 1), np.nan)
    log = FlightLog(flight.t, flight.names, (FEED_FORWARD,), ("N",), unknown)
    (bare,), (logged,) = (recorded_altitudes(Recording(flight, one), CRAZYFLIE_2_0)[0] for one in (None, log))
    assert np.abs(bare.feed_forward).max() > 0.3
    np.testing.assert_array_equal(logged.feed_forward, bare.feed_forward)
