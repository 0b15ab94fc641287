"""The PID with an observer cancels what is unexplained; the feed-forward is the paper's compensation."""

from dataclasses import replace

import numpy as np
import pytest
from pid_swarms import swarm
from resting_signals import level_command

from q2q_control.disturbance.tracker import DisturbanceTracker, Tracked, TrackerParams
from q2q_control.inputs.alignment import align
from q2q_control.pid.observed_pid import ObservedPid
from q2q_control.pid.pid import Pid
from q2q_control.pid.pid_params import PidParams
from q2q_model.downwash.correction.residual_process import REAL_FLIGHTS
from q2q_model.geometry.rotations import matrix_from_quat, quat_from_euler
from q2q_model.signals.values import Array, Names, SwarmImu
from q2q_model.vehicle.constants import CRAZYFLIE_2_0, GRAVITY, TEXTBOOK_065

DT = 0.01
"""[s]"""
GAINS = PidParams(k_p_z=10.0, k_d_z=5.0)


def heights(controller: Pid | ObservedPid, push: float, latency: int) -> Array:
    """Return the heights [m] of a vehicle without lag, pushed by `push` [m/s^2], commanded late."""
    height, climb, seen = 0.0, 0.0, []
    acting = [TEXTBOOK_065.hover_thrust] * latency
    for k in range(600):
        state, setpoint, _ = swarm(("cf1",), k * DT)
        state = replace(state, pos=np.array([[0, 0, height]]), vel=np.array([[0, 0, climb]]))
        acting.append(controller.update(state, setpoint, None).thrust[0])
        acc = acting.pop(0) / TEXTBOOK_065.mass - GRAVITY + push
        height, climb = height + DT * climb + 0.5 * DT**2 * acc, climb + DT * acc
        seen.append(height)
    return np.array(seen)


def test_a_constant_push_leaves_an_offset_with_the_pd_and_none_with_the_observer():
    push = -0.5
    plain = heights(Pid(GAINS, TEXTBOOK_065), push, 2)
    observed = heights(ObservedPid(GAINS, TrackerParams(latency=0.02), TEXTBOOK_065), push, 2)
    assert plain[-1] == pytest.approx(push / GAINS.k_p_z, rel=1e-3)
    assert abs(observed[-1]) < 1e-5  # poles of 6 and 3 rad/s: 18 time constants
    assert abs(observed.min()) < abs(plain.min())


def test_saturation_for_seconds_winds_nothing_up():
    params = replace(GAINS, thrust_limited=True)
    pid = ObservedPid(params, TrackerParams(latency=0.0), TEXTBOOK_065)
    height, climb, seen = 0.0, 0.0, []
    for k in range(2500):
        state, setpoint, _ = swarm(("cf1",), k * DT)
        state = replace(state, pos=np.array([[0, 0, height]]), vel=np.array([[0, 0, climb]]))
        push = -0.5 if k < 400 else 0.0  # 6.6 N leave 0.344 m/s^2
        acc = pid.update(state, setpoint, None).thrust[0] / TEXTBOOK_065.mass - GRAVITY + push
        height, climb = height + DT * climb + 0.5 * DT**2 * acc, climb + DT * acc
        seen.append(height)
    # free of the push it climbs at 0.344 m/s^2 as the PD alone would: no stored error throws it over
    assert max(seen) < 0.05 * abs(min(seen))
    assert abs(seen[-1]) < 1e-4


def test_thrust_lag_and_tilt_are_explained_and_not_taken_for_disturbance():
    pid = ObservedPid(GAINS, TrackerParams(latency=0.0), CRAZYFLIE_2_0)
    quat = quat_from_euler([0.2], [0.1], [0.5])
    axis = matrix_from_quat(quat)[0, :, 2]
    thrust, pos, vel = CRAZYFLIE_2_0.hover_thrust, np.zeros(3), np.zeros(3)
    keep = np.exp(-DT / CRAZYFLIE_2_0.thrust_lag)
    for k in range(150):
        state, setpoint, _ = swarm(("cf1",), k * DT)
        state = replace(state, pos=pos[None].copy(), vel=vel[None].copy(), quat=quat)
        setpoint = replace(setpoint, pos=pos[None] + [[0.0, 0.0, 0.05 * np.sin(0.2 * k)]])
        command = pid.update(state, setpoint, None)
        after = command.thrust[0] + keep * (thrust - command.thrust[0])
        mean = command.thrust[0] + (thrust - command.thrust[0]) * (1.0 - keep) * CRAZYFLIE_2_0.thrust_lag / DT
        acc = axis * mean / CRAZYFLIE_2_0.mass - [0.0, 0.0, GRAVITY]
        pos, vel, thrust = pos + DT * vel + 0.5 * DT**2 * acc, vel + DT * acc, after
    # thrust within a tick is not constant: the position is off by its curvature, 1e-6 m
    assert np.abs(pid._tracker._observer.estimate.disturbance).max() < 0.02


def test_a_vehicle_at_rest_with_motors_off_is_not_measured() -> None:
    """It hovers, stands for 5 s, and hovers again; a push by rotors that lag fades within 2 s."""
    tracker = DisturbanceTracker(TrackerParams(latency=0.0), CRAZYFLIE_2_0, REAL_FLIGHTS)
    pushes, residuals = np.empty(1400), np.empty(1400)
    for k in range(1400):
        state, setpoint, interference = swarm(("cf1",), k * DT)
        tick, stands = align(state, setpoint, interference), 500 <= k < 1000
        tracked = tracker.update(tick)
        pushes[k], residuals[k] = tracked.estimate.disturbance[0, 2], tracked.residual[0]
        thrust = np.array([0.0 if stands else CRAZYFLIE_2_0.hover_thrust])
        tracker.sent(level_command(k * DT, ("cf1",), thrust), tick)
        tracker.sense(SwarmImu(k * DT, ("cf1",), np.array([[0.0, 0.0, GRAVITY]]), np.zeros((1, 3))))
    kept = (pushes - residuals)[550:1000]
    np.testing.assert_allclose(kept, kept[0], rtol=1e-9)
    assert abs(residuals[999]) < 1e-9
    assert np.abs(pushes[1200:]).max() < 0.05


def heights_of_light(share: float, drop: float) -> Array:
    """Return errors of height [m]: a share of the nominal mass, and a setpoint that drops after 7 s."""
    pid = ObservedPid(GAINS, TrackerParams(latency=0.0), CRAZYFLIE_2_0, (), REAL_FLIGHTS)
    height, climb, errors = 1.0, 0.0, np.empty(1400)
    thrust, keep = share * CRAZYFLIE_2_0.hover_thrust, np.exp(-DT / CRAZYFLIE_2_0.thrust_lag)
    for k in range(1400):
        goal = 1.0 if k < 700 else 1.0 - drop
        state, setpoint, _ = swarm(("cf1",), k * DT)
        state = replace(state, pos=np.array([[0, 0, height]]), vel=np.array([[0, 0, climb]]))
        setpoint = replace(setpoint, pos=np.array([[0.0, 0.0, goal]]))
        command = pid.update(state, setpoint, None).thrust[0]
        thrust = command + keep * (thrust - command)
        felt = thrust / (share * CRAZYFLIE_2_0.mass)
        pid.sense(SwarmImu(k * DT, ("cf1",), np.array([[0.0, 0.0, felt]]), np.zeros((1, 3))))
        acc = felt - GRAVITY
        height, climb = height + DT * climb + 0.5 * DT**2 * acc, climb + DT * acc
        errors[k] = height - goal
    return errors


@pytest.mark.parametrize(("share", "drop"), [(1.0, 1.0), (0.85, 1.0), (0.7, 0.4), (0.7, 0.8)])
def test_a_drop_in_flight_forgets_nothing_of_a_light_vehicle(share: float, drop: float) -> None:
    """Its thrust falls to 0.25 to 0.5 of the nominal weight."""
    errors = heights_of_light(share, drop)
    assert abs(errors[699]) < 1e-3
    assert np.abs(errors[800:]).max() < 0.07  # of the step itself, not of what is learned: 0.3 m
    assert abs(errors[-1]) < 1e-4


PUSHED = {"cf1": -4.0, "cf2": 0.0, "cf3": -1.0}
"""Predicted and actual downwash of vehicles at rest [m/s^2]."""


def track(tracker: DisturbanceTracker, names: Names, t: float) -> Tracked:
    """Return the estimates of vehicles at rest, whose thrust carries them and the downwash."""
    state, setpoint, interference = swarm(names, t)
    eta = np.array([[0.0, 0.0, PUSHED[name]] for name in names])
    tick = align(state, setpoint, replace(interference, acc=eta))
    tracked = tracker.update(tick)
    thrust = TEXTBOOK_065.mass * (GRAVITY - eta[:, 2])
    tracker.sent(level_command(t, names, thrust, status=state.status), tick)
    return tracked


@pytest.mark.parametrize("after", [("cf2", "cf1"), ("cf3", "cf2", "cf1"), ("cf2",), ("cf3", "cf1")])
def test_downwash_goes_with_its_vehicle_when_rows_change(after: Names):
    """At rest nothing is unexplained; the row of another's downwash moved cf1 by 0.02 m/s in one tick."""
    tracker = DisturbanceTracker(TrackerParams(latency=0.0), TEXTBOOK_065)
    for k in range(40):
        track(tracker, ("cf1", "cf2"), k * DT)
    for k in range(40, 43):
        estimate = track(tracker, after, k * DT).estimate
        kept = [row for row, name in enumerate(after) if name != "cf3"]  # a new vehicle hovers at first
        np.testing.assert_allclose(estimate.vel[kept], 0.0, atol=1e-12)  # rounding of 40 ticks
        np.testing.assert_allclose(estimate.disturbance[kept], 0.0, atol=1e-12)
