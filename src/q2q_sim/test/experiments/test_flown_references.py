"""References that flew, and not those that were planned, are flown again, read at their own samples."""

from dataclasses import replace

import numpy as np
import pytest

from q2q_model.flights.flight import FLIGHT_FIELDS, Flight, of_rows, of_vehicle
from q2q_model.geometry.rotations import UP, quat_from_euler
from q2q_model.recordings.flight_recording import Recording
from q2q_model.trajectory.flatness import flat_state
from q2q_model.vehicle.constants import CRAZYFLIE_2_0, GRAVITY
from q2q_sim.experiments.validation.flight_alone import flight_alone, is_alone
from q2q_sim.experiments.validation.recorded.recorded_law import ReadFlight, RecordedLaw, feedback, read_law
from q2q_sim.experiments.validation.recorded.tracked_flight import tracked_flight

DT = 0.01
T = DT * np.arange(2000)[:, None, None]
STEP_S = 8.0
"""Time of a step [s]."""
LATE = 11
"""Rows by which the vehicles point late: those of test_recorded_law."""
LAW = RecordedLaw(
    k_p=np.array([40.0, 40.0, 20.0]),
    k_d=np.array([20.0, 20.0, 10.0]),
    k_i=np.full(3, 0.6),
    offset=np.zeros((2, 3)),
    rms=0.0,
)


def flown(every: int = 1, step: float = 0.0) -> Flight:
    """Return a flight by LAW along references that its controllers hold for `every` ticks.

    Those have the rates of a smooth motion, and none of a step [m] on it.
    """
    axis, vehicle = np.arange(3), np.arange(2)[:, None]
    smooth = 0.3 * np.sin((2.0 + 0.7 * axis + 0.3 * vehicle) * T) + 2.0 * UP
    away = 0.02 * np.sin((5.0 + 1.3 * axis - 0.9 * vehicle) * T + axis)
    late = (T >= STEP_S) * (1.0 - np.exp(-3.0 * np.maximum(T - STEP_S, 0.0))) * step * UP
    pos, rate = smooth - away + late, np.gradient(smooth, DT, axis=0)
    vel, row = np.gradient(pos, DT, axis=0), np.arange(len(T)) // every * every
    ref = smooth + (T >= STEP_S) * step * UP
    ref_pos, ref_vel, ref_acc = (one[row] for one in (ref, rate, np.gradient(rate, DT, axis=0)))
    error = ref_pos - pos
    acc = ref_acc + feedback(LAW, error, ref_vel - vel, np.cumsum(error, axis=0) * DT)
    pointed = flat_state(acc, np.zeros(acc.shape[:2]))
    quat = quat_from_euler(*(np.roll(angle, LATE, axis=0) for angle in (pointed.roll, pointed.pitch)), 0.0)
    thrust = CRAZYFLIE_2_0.mass * pointed.thrust
    unknown = {name: np.full_like(pos, np.nan) for of in FLIGHT_FIELDS.values() for name in of.values()}
    unknown |= {name: np.full_like(thrust, np.nan) for name in ("thrust", "roll", "pitch", "command_status")}
    known = {
        "pos": pos, "vel": vel, "quat": quat, "ref_pos": ref_pos, "ref_vel": ref_vel, "ref_acc": ref_acc,
        "mocap_pos": pos, "mocap_quat": quat, "thrust": thrust,
        "specific_force_body": pointed.thrust[..., None] * UP,
    }  # fmt: skip
    return Flight(name="flown", names=("cf1", "cf2"), t=T[:, 0, 0], **(unknown | known))


def read(flight: Flight) -> ReadFlight:
    """Return the flight with its law."""
    return read_law(tracked_flight(Recording(flight), CRAZYFLIE_2_0), CRAZYFLIE_2_0)


def replanned(flight: Flight) -> Flight:
    """Return a flight whose references were planned 0.5 m higher, and led back by a replanner."""
    return replace(
        flight,
        ref_pos=flight.ref_pos + 0.5 * UP,
        safe_pos=flight.ref_pos,
        safe_vel=flight.ref_vel,
        safe_acc=flight.ref_acc,
    )


def test_what_a_replanner_made_of_the_plan_is_flown_again() -> None:
    flight = flown()
    found = tracked_flight(Recording(replanned(flight)), CRAZYFLIE_2_0)
    whole = tracked_flight(Recording(flight), CRAZYFLIE_2_0)
    np.testing.assert_array_equal(found.ref_pos, whole.ref_pos)
    np.testing.assert_array_equal(found.error, whole.error)


def test_a_vehicle_alone_is_flown_again_along_what_a_replanner_made_of_the_plan() -> None:
    alone = of_vehicle(replace(flown(), thrust=np.full((len(T), 2), np.nan)), "cf1")
    assert is_alone(Recording(replanned(alone)))
    np.testing.assert_array_equal(
        flight_alone(Recording(replanned(alone))).ref_pos, flight_alone(Recording(alone)).ref_pos
    )


@pytest.mark.parametrize("every", [1, 5, 10])
def test_gains_are_those_that_flew_where_controllers_hold_their_references(every: int) -> None:
    """Between samples of a held reference the interpolated one is ahead by up to 3 cm."""
    law = read(flown(every)).law
    np.testing.assert_allclose(law.k_p, LAW.k_p, rtol=5e-3)
    np.testing.assert_allclose(law.k_d, LAW.k_d, rtol=5e-3)


@pytest.mark.parametrize("every", [5, 10])
def test_rare_references_of_a_short_flight_are_enough(every: int) -> None:
    """Of 9 s are left 50 samples at 10 Hz; the time with commands counts, not the rate of the references."""
    law = read(of_vehicle(of_rows(flown(every), slice(0, 900)), "cf1")).law
    np.testing.assert_allclose(law.k_p, LAW.k_p, rtol=0.02)
    np.testing.assert_allclose(law.k_d, LAW.k_d, rtol=0.02)


def test_a_flight_of_few_commands_is_refused_with_what_it_has_and_needs() -> None:
    flight = flown(10)
    few = replace(flight, thrust=np.where(T[..., 0] < 5.0, flight.thrust, np.nan))
    needs = r"s with thrust commands, and \d+ samples of references.*need 2 s, 40 samples, and rates of each"
    with pytest.raises(ValueError, match=needs):
        read(of_rows(few, slice(350, 2000)))


def test_beside_a_step_without_rates_the_recorded_command_is_flown_again() -> None:
    """The rates of a cubic over a step of 0.2 m would command up to 22 m/s^2 more."""
    flight, unknown = flown(step=0.2), np.full((len(T), 2, 3), np.nan)
    found = read(replace(flight, ref_vel=unknown, ref_acc=unknown))
    again, law = found.flight, found.law
    error = again.ref_pos - again.pos
    integral = again.dt * np.cumsum(error, axis=0)
    acc = again.ref_acc + law.offset + feedback(law, error, again.ref_vel - again.vel, integral)
    size = np.linalg.norm(acc + GRAVITY * UP, axis=-1)
    near = np.abs(again.t - STEP_S) < 0.3
    assert law.k_p[2] == pytest.approx(20.0, rel=0.01)
    np.testing.assert_allclose(size[near], again.thrust[near] / CRAZYFLIE_2_0.mass, atol=0.5)
