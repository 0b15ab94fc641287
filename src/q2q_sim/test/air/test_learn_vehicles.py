"""The vehicles of an air learned from flights in a known air: load, drag, motors, headroom."""

from dataclasses import replace

import numpy as np
import pytest
from known_air import PITCH, ROLL
from synthetic_air import MASS, orbit, still_record

from q2q_model.identification.push.recorded_push import FULL_DUTY
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import CRAZYFLIE_2_0, GRAVITY
from q2q_sim.air.learning.rate_load_term import rate_load_term
from q2q_sim.air.learning.records.air_record import AirRecord, Motors
from q2q_sim.air.learning.records.motor_curve import USUAL_POWER, motor_curves, usual_power
from q2q_sim.air.learning.rotor_drag_term import rotor_drag_term
from q2q_sim.air.learning.vehicle_term import accelerometer_reason, hovering_mass, vehicle_term


def test_the_load_of_the_rotors_is_found_from_what_the_motors_do_in_clear_air() -> None:
    records = [turning_flight(f"turns{k}", 3e-3 + 2e-4 * k) for k in range(5)]
    found = rate_load_term(records, CRAZYFLIE_2_0)
    assert found is not None
    assert found.term.nms == pytest.approx(3.4e-3, rel=1e-3)  # the median
    still = [replace(one, rate_body=0.01 * one.rate_body) for one in records]
    assert rate_load_term(still, CRAZYFLIE_2_0) is None


def turning_flight(name: str, load: float) -> AirRecord:
    """Return a flight whose motors work `load` [N m s] times the rates, beside I w' and a trim."""
    motion = orbit(30.0, (0.6,), 1)
    t = motion.t
    rate = np.stack([0.4 * np.sin(5.0 * t), 0.3 * np.cos(7.0 * t), 0.0 * t], axis=1)
    inertia = np.array(CRAZYFLIE_2_0.inertia)[:2]
    torque = load * rate[:, :2] + inertia * np.gradient(rate[:, :2], t, axis=0) + np.array([5e-4, -3e-4])
    lever, weight = CRAZYFLIE_2_0.arm / np.sqrt(2.0), CRAZYFLIE_2_0.hover_thrust
    share = (torque[:, :1] * ROLL + torque[:, 1:] * PITCH) / (lever * weight * USUAL_POWER)
    duty = 0.65 * (1.0 + share)[:, None]
    record = still_record(name, motion)
    motors = Motors(duty, np.full(duty.shape[:2], np.nan))
    every = np.ones_like(record.clear)
    return replace(record, lag=0.0, motors=motors, rate_body=rate[:, None], clear=every)


def battery_flight(k: int, offset: float) -> AirRecord:
    """Return a flight with an offset and a battery whose motors give (d u / 2.4 V)^1.5 of the weight."""
    record = still_record(f"battery{k}", orbit(60.0, (0.6,), k))
    t = record.motion.t
    load = 1.0 + 0.1 * np.sin(2.0 * t + k)
    hover = 3.8 - 0.1 * k - 0.002 * t
    duty = _duty(load, hover)
    volts = hover - 0.5 * (duty - 2.4 / hover)
    force = record.specific_force.copy()
    force[..., 2] += offset
    motors = Motors(np.repeat(duty[:, None, None], 4, axis=2), volts[:, None])
    return replace(record, lag=0.0, specific_force=force, thrust_ratio=load[:, None], motors=motors)


def _duty(load: Array, hover: Array) -> Array:
    """Return d with d (u_h - 0.5 (d - 2.4 / u_h)) = 2.4 load^(1 / 1.5)."""
    free = hover + 0.5 * 2.4 / hover
    return np.asarray((free - np.sqrt(free**2 - 2.0 * 2.4 * load ** (1.0 / 1.5))) / 1.0)


def _headroom(volts: float) -> float:
    """Return the thrust at full duty, at which the battery sags, over hover thrust."""
    return float((FULL_DUTY * (volts - 0.5 * (FULL_DUTY - 2.4 / volts)) / 2.4) ** 1.5)


def test_motors_that_differ_do_not_hide_the_curve() -> None:
    record = battery_flight(0, 0.2)
    assert record.motors is not None
    duty, volts = record.motors.duty, record.motors.volts
    apart = np.array([0.2, -0.2, 0.25, -0.25])[None, None] * np.sin(3.0 * record.motion.t)[:, None, None] ** 8
    each = (duty * volts[..., None] / 2.4) ** 1.5 * (1.0 + apart)  # of four rotors, their mean unchanged
    differing = replace(record, motors=Motors(2.4 * each ** (1.0 / 1.5) / volts[..., None], volts))
    (curve,) = motor_curves([differing])
    assert usual_power([curve]) == pytest.approx(1.5)
    assert curve.hover_volts == pytest.approx(2.4, rel=1e-6)
    assert curve.headroom(3.8, 1.5) == pytest.approx(_headroom(3.8), rel=0.02)


def test_what_each_motor_works_at_hover_is_found() -> None:
    work = np.array([1.1, 0.9, 1.15, 0.85])
    records = []
    for k in range(3):
        record = battery_flight(k, 0.0)
        assert record.motors is not None
        duty = record.motors.duty * work ** (1.0 / USUAL_POWER)
        records.append(replace(record, motors=Motors(duty, record.motors.volts)))
    for curve in motor_curves(records):
        assert curve.work == pytest.approx(work, rel=1e-6)
    found = vehicle_term(records, replace(CRAZYFLIE_2_0, mass=MASS))
    assert found is not None
    assert found.term.motor_std == pytest.approx(np.std(work, ddof=1), rel=1e-6)


def test_the_drag_of_rotors_is_found_from_the_specific_force_across_their_thrust() -> None:
    record = still_record("drag", orbit(60.0, (0.6, 1.0), 4))
    vel = record.motion.vel
    force = record.specific_force + np.array([0.05, -0.02, 0.0])  # the bias of an accelerometer
    force[..., :2] -= 0.41 * vel[..., :2]
    felt = replace(record, specific_force=force, clear=np.ones_like(record.clear))
    found = rotor_drag_term([felt])
    assert found is not None
    assert found.term.per_s == pytest.approx(0.41)
    assert found.values[0].rows == 6000  # the vehicle that hovers does not determine it
    assert rotor_drag_term([replace(felt, clear=np.zeros_like(record.clear))]) is None


def test_vehicles_of_another_weight_give_no_vehicle_term() -> None:
    records = [battery_flight(k, 0.0) for k in range(3)]
    light = replace(CRAZYFLIE_2_0, mass=0.8 * MASS)
    assert vehicle_term(records, light) is None
    assert hovering_mass(records, light) == pytest.approx(MASS)


@pytest.mark.parametrize("gravities", [0.0, 1.0, 2.0])
def test_an_accelerometer_with_gravity_twice_or_without_it_is_named(gravities: float) -> None:
    still = still_record("hover", orbit(10.0, (0.6, 1.0), 1))
    clear = np.ones_like(still.clear)
    record = replace(still, specific_force=gravities * still.specific_force, clear=clear)
    reason = accelerometer_reason([record])
    if gravities == 1.0:
        assert reason == ""
    else:
        assert reason.startswith(f"the accelerometer reads {gravities * GRAVITY:.2f} m/s^2 upwards: record")


def test_offset_lag_and_headroom_of_the_vehicles_are_found() -> None:
    offsets = (0.1, 0.3, 0.2, 0.4)
    vehicle = replace(CRAZYFLIE_2_0, mass=MASS)
    found = vehicle_term([battery_flight(k, offset) for k, offset in enumerate(offsets)], vehicle)
    assert found is not None
    assert found.term.offset_mean_mps2 == pytest.approx(np.mean(offsets), abs=1e-6)
    assert found.term.offset_std_mps2 == pytest.approx(np.std(offsets, ddof=1), abs=1e-6)
    assert found.term.thrust_lag_s == 0.07
    at_full, starts = _headroom(3.8), [_headroom(3.8 - 0.1 * k) for k in range(4)]
    assert found.term.headroom == pytest.approx(np.median(starts), rel=0.03)
    assert found.term.headroom_std == pytest.approx(np.std(starts, ddof=1), rel=0.1)
    at_empty = _headroom(3.5)
    assert found.term.headroom_per_volt == pytest.approx((at_full - at_empty) / 0.3, rel=0.1)
    assert found.term.discharge_v_per_s == pytest.approx(0.002, rel=0.15)  # duty rises as it falls
