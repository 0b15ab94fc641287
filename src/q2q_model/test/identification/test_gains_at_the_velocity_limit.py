"""Rows at the limit of the velocity setpoint do not count where accelerations are its derivative."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from made_flights import CALM, LOOP, made_flight, record_of, without

from q2q_model.flights.first_order_lag import first_order_lag
from q2q_model.flights.flight import Flight
from q2q_model.identification.gain_notes import gain_notes
from q2q_model.identification.gains.altitude_from_flight import altitude_record
from q2q_model.identification.gains.altitude_record import AltitudeRecord
from q2q_model.identification.gains.command_gains import gains_from_commands
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import CRAZYFLIE_2_0


def random_walk(given: Array, dt: float = 0.01) -> AltitudeRecord:
    """Return a vehicle that is given accelerations (T,), with a velocity setpoint cut at 0.25 m/s.

    It follows 0.2 s late. The record has the derivative of its velocity setpoint, and not what was given.
    """
    limited = np.clip((np.cumsum(given) - 0.5 * given) * dt, -0.25, 0.25)
    place = np.cumsum(limited) * dt
    ref = np.stack([place, limited, np.gradient(limited, dt)], axis=-1)[:, None]  # (T, 1, 3)
    pos, vel, empty = (np.zeros((given.size, 1, 3)) for _ in range(3))
    for values, wanted in ((pos, place), (vel, limited)):
        values[:, 0, 2] = first_order_lag(wanted[:, None], dt * np.arange(given.size), 0.2)[:, 0]
    error, rate = (ref[..., k] - values[..., 2] for k, values in enumerate((pos, vel)))
    commanded = given[:, None] + LOOP.k_p * error + LOOP.k_d * rate
    commanded += 0.01 * np.random.default_rng(3).standard_normal(commanded.shape)
    unknown, t = np.full_like(commanded, np.nan), dt * np.arange(given.size)
    return AltitudeRecord(
        "walk", ("a",), dt, t, pos, vel, empty, ref, commanded, unknown, 0.0 * commanded, 0, t.size,
        acc_differentiated=True,
    )  # fmt: skip


def test_rows_in_which_the_velocity_setpoint_is_at_its_limit_do_not_move_the_gains() -> None:
    """There its derivative is not the acceleration that the controller was given."""
    t = np.arange(0.0, 60.0, 0.01)
    record = random_walk(0.6 * np.cos(1.5 * t) + 0.3 * np.cos(0.7 * t))
    fit = gains_from_commands([record])
    assert fit.limited == pytest.approx((np.abs(record.ref[..., 1]) == 0.25).mean(), abs=0.03)
    assert fit.k_p.low <= LOOP.k_p <= fit.k_p.high
    assert fit.k_d.low <= LOOP.k_d <= fit.k_d.high
    assert fit.k_p.high - fit.k_p.low < 0.1 * LOOP.k_p
    assert gain_notes(fit, [], CRAZYFLIE_2_0)[0].startswith(f"{fit.limited:.0%} of the rows with commands")


def oscillation(made: Flight, acc_of: Callable[[Array, Array], Array]) -> Flight:
    """Return a flight that follows a vertical sine too, with z_ref'' of the record made of t and z_ref'."""
    place, rate = 0.2 * np.sin(2.0 * made.t), 0.4 * np.cos(2.0 * made.t)
    given, recorded = -0.8 * np.sin(2.0 * made.t), acc_of(made.t, rate)
    moves = {
        **dict.fromkeys(("pos", "mocap_pos", "ref_pos"), place),
        **dict.fromkeys(("vel", "ref_vel"), rate),
        "ref_acc": recorded,
    }
    up = np.array([0.0, 0.0, 1.0])
    found = {name: getattr(made, name) + one[:, None, None] * up for name, one in moves.items()}
    return replace(made, thrust=made.thrust + CRAZYFLIE_2_0.mass * given[:, None], **found)


def test_rows_at_the_largest_velocity_count_where_accelerations_are_recorded() -> None:
    calm = made_flight(CALM)
    record = altitude_record(oscillation(calm, lambda t, _: -0.8 * np.sin(2.0 * t)), CRAZYFLIE_2_0)
    moving = gains_from_commands([record])
    assert moving.limited == 0.0
    assert moving.k_p.value == pytest.approx(LOOP.k_p, rel=1e-4)
    assert moving.k_d.value == pytest.approx(LOOP.k_d, rel=1e-4)


@pytest.mark.parametrize("lost", [(), (slice(1000, 1002), slice(1500, 1501))])
def test_accelerations_that_are_differences_of_velocities_are_found(lost: tuple[slice, ...]) -> None:
    flight = oscillation(made_flight(CALM), lambda t, rate: np.gradient(rate, t))
    record = altitude_record(without(flight, *lost), CRAZYFLIE_2_0)
    # of a sine, arccos(0.98) on both sides of a top and of a bottom: 0.128; 3 rows more on each: 0.038
    assert gains_from_commands([record]).limited == pytest.approx(0.166, abs=0.01)


def test_vehicles_that_climb_at_a_constant_rate_have_the_gains_of_hovering_ones() -> None:
    """All their rows are at the largest velocity, and its derivative is right."""
    still = record_of(CALM)
    pos, vel, ref = still.pos.copy(), still.vel.copy(), still.ref.copy()
    pos[..., 2] += 0.2 * still.t[:, None]
    ref[..., 0] += 0.2 * still.t[:, None]
    vel[..., 2] += 0.2
    ref[..., 1] += 0.2
    risen = replace(still, pos=pos, vel=vel, ref=ref)
    hovering, climbing = gains_from_commands([still]), gains_from_commands([risen])
    assert climbing.limited == 0.0
    assert climbing.k_p.as_list() == pytest.approx(hovering.k_p.as_list(), rel=1e-6)
    assert climbing.k_d.as_list() == pytest.approx(hovering.k_d.as_list(), rel=1e-6)
