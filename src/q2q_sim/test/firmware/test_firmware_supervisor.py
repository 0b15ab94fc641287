"""Arming, watchdogs, emergency stop, tumbling: what the supervisor allows, and when."""

from dataclasses import replace

import numpy as np
import pytest
from firmware_hover import HOVER, hovering

from cflib_fleet import CflibFleet
from q2q_model.vehicle.constants import CRAZYFLIE_2_0
from q2q_sim.firmware.commander.planner import PlannerResult, Target, Vertical
from q2q_sim.firmware.commander.setpoint import Mode, Setpoint
from q2q_sim.firmware.controllers.columns import MOTOR, SET_THRUST
from q2q_sim.firmware.firmware_build import Build
from q2q_sim.firmware.motors.airframe import airframe_of
from q2q_sim.firmware.parameters.parameter_values import Parameters
from q2q_sim.firmware.supervisor.info import Info
from q2q_sim.firmware.supervisor.rules import MOTORS_MAY_RUN, Condition, Rule, State, next_state
from q2q_sim.firmware.supervisor.supervisor import Supervisor, SupervisorInput

LOOK_S = 0.04
"""The supervisor looks 25 times per second."""


def state(crazyflies: CflibFleet) -> State:
    return crazyflies.firmware().supervisor.state


def test_rules_fire_on_set_on_clear_and_on_all_clear_but_not_while_blocked() -> None:
    a, b, c = Condition.ARMED, Condition.TUMBLED, Condition.CRASHED
    assert Rule(State.LOCKED).fires(Condition.NONE)
    assert Rule(State.LOCKED, if_set=a | b).fires(b)
    assert not Rule(State.LOCKED, if_set=a | b).fires(c)
    assert Rule(State.LOCKED, if_clear=a).fires(b)
    assert not Rule(State.LOCKED, if_clear=a).fires(a | b)
    assert Rule(State.LOCKED, if_all_clear=a | b).fires(c)
    assert not Rule(State.LOCKED, if_all_clear=a | b).fires(b)
    assert not Rule(State.LOCKED, unless=c).fires(c)


@pytest.mark.parametrize("start", list(State))
def test_an_emergency_stop_ends_every_state_that_may_run_motors_within_two_looks(start: State) -> None:
    after = next_state(next_state(start, Condition.EMERGENCY_STOP), Condition.EMERGENCY_STOP)
    assert after not in MOTORS_MAY_RUN
    if start in MOTORS_MAY_RUN - {State.LANDED}:  # landed, it is checked anew
        assert after == State.LOCKED


def test_the_stock_build_arms_itself_and_the_other_waits_for_the_word() -> None:
    stock, careful = (CflibFleet(np.zeros((1, 4)), build=Build(auto_arming=auto)) for auto in (True, False))
    for crazyflies in (stock, careful):
        crazyflies.fly(0.5)
    assert state(stock) == State.READY_TO_FLY
    assert state(careful) == State.CHECKS_PASSED
    assert careful.firmware().info & Info.CAN_BE_ARMED
    assert careful.firmware().supervisor.request_arming(arm=True)
    careful.fly(0.2)
    assert state(careful) == State.READY_TO_FLY


def test_an_armed_vehicle_that_does_not_fly_disarms_after_30_s() -> None:
    crazyflies = CflibFleet(np.zeros((1, 4)), build=Build(auto_arming=False))
    crazyflies.fly(0.5)
    crazyflies.firmware().supervisor.request_arming(arm=True)
    crazyflies.fly(29.0)
    assert crazyflies.firmware().supervisor.armed
    crazyflies.fly(2.0)
    assert not crazyflies.firmware().supervisor.armed
    assert state(crazyflies) == State.CHECKS_PASSED


def test_half_a_second_without_setpoint_levels_out_and_two_cut_the_motors() -> None:
    crazyflies = hovering()
    tilted = Setpoint(
        roll=Mode.ABS, pitch=Mode.ABS, yaw=Mode.VELOCITY, attitude_deg=(8.0, 0.0, 0.0), thrust_pwm=46000
    )
    crazyflies.firmware().accept(tilted)
    crazyflies.fly(0.5)
    assert state(crazyflies) == State.FLYING
    assert crazyflies.firmware().flown.attitude_deg[0] == 8.0
    crazyflies.fly(LOOK_S + 0.01)
    assert state(crazyflies) == State.LEVEL_OUT
    assert crazyflies.firmware().flown.attitude_deg == (0.0, 0.0, 0.0)
    assert crazyflies.firmware().flown.thrust_pwm == 46000
    crazyflies.fly(1.4)
    assert crazyflies.firmware().supervisor.motors_may_run
    crazyflies.fly(0.1 + 2 * LOOK_S)
    assert state(crazyflies) == State.LOCKED
    assert not crazyflies.firmware().supervisor.motors_may_run
    crazyflies.fly(1.5, crazyflies.hold(HOVER))
    assert crazyflies.pos()[2] == 0.0  # locked: it fell, and obeys nobody
    assert state(crazyflies) == State.LOCKED


def test_levelling_out_keeps_the_rates_of_roll_and_pitch_and_drifts_under_mellinger() -> None:
    crazyflies = hovering()
    firmware = crazyflies.firmware()
    firmware.parameters.set("stabilizer.controller", 2)
    crazyflies.fly(1.0, crazyflies.hold(HOVER))
    turning = replace(HOVER, rate_deg=(0.0, 20.0, 30.0), attitude_deg=(0.0, 0.0, 5.0))
    firmware.accept(turning)
    crazyflies.fly(0.5 + LOOK_S)
    assert state(crazyflies) == State.LEVEL_OUT
    off = Mode.DISABLE
    assert firmware.flown == replace(
        turning, x=off, y=off, roll=Mode.ABS, pitch=Mode.ABS, yaw=Mode.VELOCITY, rate_deg=(0.0, 20.0, 0.0)
    )
    before = crazyflies.pos()[0]
    crazyflies.fly(1.0)
    assert crazyflies.pos()[0] - before > 0.2  # nose down at a wanted rate, level or not


def test_a_setpoint_is_flown_one_step_after_the_supervisor_lets_the_vehicle_fly() -> None:
    crazyflies = CflibFleet(np.zeros((1, 4)))
    firmware, lift = crazyflies.firmware(), Setpoint(roll=Mode.ABS, pitch=Mode.ABS, thrust_pwm=20000.0)
    while state(crazyflies) != State.READY_TO_FLY:
        firmware.accept(lift)
        first, others = firmware.tick()
    assert (first[SET_THRUST], others[SET_THRUST]) == (0.0, 20000.0)
    first, others = firmware.tick()
    assert (first[SET_THRUST], others[SET_THRUST]) == (20000.0, 20000.0)


def test_a_vehicle_that_must_be_armed_idles_at_7000_pwm_without_flying() -> None:
    crazyflies = CflibFleet(np.zeros((1, 4)), build=Build(auto_arming=False))
    crazyflies.fly(0.5)
    motors = crazyflies.firmware().rows.memory[MOTOR : MOTOR + 4]
    np.testing.assert_array_equal(motors, 0.0)
    assert crazyflies.firmware().supervisor.request_arming(arm=True)
    crazyflies.fly(0.5)
    np.testing.assert_array_equal(motors, 7000.0)
    assert state(crazyflies) == State.READY_TO_FLY
    assert crazyflies.firmware().supervisor.request_arming(arm=False)
    crazyflies.fly(0.1)
    np.testing.assert_array_equal(motors, 0.0)
    assert CflibFleet(np.zeros((1, 4))).firmware().parameters["powerDist.idleThrust"] == 0


def test_info_shows_a_landing_as_an_active_plan_and_a_plan_that_was_given_up(grounded: CflibFleet) -> None:
    firmware = grounded.firmware()
    firmware.planner.take_off(Vertical(1.0, 1.0), firmware.seconds)
    grounded.fly(1.5)
    firmware.planner.land(Vertical(0.0, 2.0), firmware.seconds)
    grounded.fly(0.5)
    assert firmware.info & Info.PLAN_ACTIVE
    assert not firmware.info & (Info.PLAN_FINISHED | Info.PLAN_DISABLED)
    grounded.fly(2.0)
    assert firmware.info & Info.PLAN_FINISHED
    assert not firmware.info & Info.PLAN_ACTIVE
    firmware.planner.go_to(Target((1.0, 0.0, 1.0), 0.0, 0.0, linear=True), firmware.seconds)
    grounded.fly(0.1)
    assert firmware.info & Info.PLAN_DISABLED
    assert not firmware.info & Info.PLAN_ACTIVE


def test_a_linear_go_to_in_no_time_leaves_the_vehicle_without_setpoints() -> None:
    crazyflies = hovering()
    firmware = crazyflies.firmware()
    firmware.relax()
    firmware.planner.go_to(Target((0.0, 0.0, 1.0), 0.0, 1.0), firmware.seconds)
    crazyflies.fly(1.5)
    assert (
        firmware.planner.go_to(Target((0.5, 0.0, 1.0), 0.0, 0.0, linear=True), firmware.seconds)
        == PlannerResult.OK
    )
    crazyflies.fly(0.5 + 2 * LOOK_S)
    assert state(crazyflies) == State.LEVEL_OUT


def test_a_new_setpoint_in_time_ends_the_levelling() -> None:
    crazyflies = hovering()
    crazyflies.fly(1.0)
    assert state(crazyflies) == State.LEVEL_OUT
    crazyflies.fly(0.1, crazyflies.hold(HOVER))
    assert state(crazyflies) == State.FLYING


@pytest.mark.parametrize("how", ["stop", "watchdog", "parameter"])
def test_emergency_stops_stop_the_motors_for_good(how: str) -> None:
    crazyflies = hovering()
    one = crazyflies.firmware()
    if how == "stop":
        one.supervisor.stop()
    elif how == "watchdog":
        one.supervisor.feed(one.now_ms)
        crazyflies.fly(0.9, crazyflies.hold(HOVER))
        assert state(crazyflies) == State.FLYING
        crazyflies.fly(0.1, crazyflies.hold(HOVER))
    else:
        one.parameters.set("stabilizer.stop", 1)
    crazyflies.fly(2 * LOOK_S + 0.01, crazyflies.hold(HOVER))
    assert state(crazyflies) == State.LOCKED
    crazyflies.fly(2.0, crazyflies.hold(HOVER))
    assert crazyflies.pos()[2] == 0.0


def look(now_ms: int, acc_z: float, *, running: bool = True) -> SupervisorInput:
    return SupervisorInput(now_ms=now_ms, acc=(0.0, 0.0, acc_z), setpoint_ms=now_ms, motors_running=running)


@pytest.mark.parametrize(("acc_z", "after_ms"), [(-1.0, 100), (0.4, 1000)])
def test_a_vehicle_that_lies_on_its_side_or_back_has_crashed_until_it_is_recovered_upright(
    acc_z: float, after_ms: int
) -> None:
    parameters, one = Parameters(airframe_of(CRAZYFLIE_2_0)), Supervisor(auto_arming=True)
    for now in range(0, 1000, 40):
        one.update(look(now, 1.0), parameters)
    assert one.state == State.FLYING
    fell = 1000
    for now in range(fell, fell + after_ms + 1, 40):
        one.update(look(now, acc_z), parameters)
        assert one.state == State.FLYING
    one.update(look(fell + after_ms + 40, acc_z), parameters)
    assert one.state == State.CRASHED
    assert not one.recover()
    one.update(look(5000, 1.0, running=False), parameters)
    assert one.state == State.CRASHED
    assert one.recover()
    one.update(look(5040, 1.0, running=False), parameters)
    assert one.state == State.CHECKS_NOT_PASSED


def test_falling_freely_is_no_tumbling() -> None:
    parameters, one = Parameters(airframe_of(CRAZYFLIE_2_0)), Supervisor(auto_arming=True)
    for now in range(0, 4000, 40):
        one.update(look(now, 1.0 if now < 1000 else 0.05), parameters)
    assert one.state == State.FLYING


def test_the_supervisor_port_answers_cflib(grounded: CflibFleet) -> None:
    supervisor = pytest.importorskip("cflib.crazyflie.supervisor").Supervisor
    wire = grounded.wire()
    client = supervisor(wire)
    client.send_arming_request(do_arm=False)
    assert wire.answers[-1][1:] == b"\x81\x01\x00"
    grounded.fly(0.3)  # the stock build arms itself again
    client.send_arming_request(do_arm=True)
    assert wire.answers[-1][1:] == b"\x81\x01\x01"
    (bits,) = grounded.fleet.vehicles[0].handle(b"\x9c\x0c")
    assert client.decode_bitfield(int.from_bytes(bits[2:], "little")) == [
        "Is armed", "Is auto armed", "Can fly", "Finished HL trajectory",
    ]  # fmt: skip
    assert grounded.fleet.vehicles[0].handle(b"\x9c\x04")[0][1:] == b"\x84\x01"
    client.send_emergency_stop()
    grounded.fly(0.2)
    assert state(grounded) == State.LOCKED
