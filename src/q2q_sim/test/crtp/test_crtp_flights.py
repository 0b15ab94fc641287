"""Whole flights over CRTP in simulated time: clients' own words in, trajectories out."""

import numpy as np
import pytest

from cflib_fleet import CflibFleet
from q2q_model.geometry.rotations import identity_quat
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import CRAZYFLIE_2_0
from q2q_sim.air.wake_laws import WakeLaw
from q2q_sim.firmware.firmware_build import Build
from q2q_sim.firmware.supervisor.rules import State

commander = pytest.importorskip("cflib.crazyflie.commander", reason="cflib is not installed").Commander
high_level = pytest.importorskip("cflib.crazyflie.high_level_commander").HighLevelCommander
localization = pytest.importorskip("cflib.crazyflie.localization").Localization

MELLINGER = 2


@pytest.mark.parametrize("controller", [1, MELLINGER])
def test_take_off_go_to_and_land_end_where_they_should(grounded: CflibFleet, controller: int) -> None:
    grounded.firmware().parameters.set("stabilizer.controller", controller)
    crazyflies = high_level(grounded.wire())
    crazyflies.takeoff(1.0, 2.0)
    grounded.fly(4.0)
    np.testing.assert_allclose(grounded.pos(), [0.0, 0.0, 1.0], atol=0.12)  # the PID's integral overshoots
    crazyflies.go_to(0.6, -0.4, 1.2, 0.0, 3.0)
    grounded.fly(5.0)
    np.testing.assert_allclose(grounded.pos(), [0.6, -0.4, 1.2], atol=0.08)
    crazyflies.land(0.0, 2.0)
    grounded.fly(5.0)
    np.testing.assert_allclose(grounded.pos(), [0.6, -0.4, 0.0], atol=0.08)
    assert grounded.firmware().supervisor.state == State.LANDED


def test_a_client_that_dies_in_flight_leaves_its_vehicle_level_then_on_the_ground_then_free() -> None:
    crazyflies = CflibFleet(np.array([[0.0, 0.0, 1.0, 0.0]]))
    sender = commander(crazyflies.wire())

    def hover(_: float) -> None:
        sender.send_position_setpoint(0.0, 0.0, 1.0, 0.0)

    crazyflies.fly(3.0, hover)
    crazyflies.fly(1.0)
    assert crazyflies.firmware().supervisor.state == State.LEVEL_OUT
    assert crazyflies.pos()[2] > 0.5
    crazyflies.fly(2.5)  # cut at 2 s, half a second of fall, silent for long: somebody pulls the battery
    assert crazyflies.pos()[2] == 0.0
    crazyflies.fly(0.5)
    assert crazyflies.firmware().supervisor.state == State.READY_TO_FLY
    high_level(crazyflies.wire()).takeoff(0.5, 1.0)
    crazyflies.fly(2.5)
    assert crazyflies.pos()[2] == pytest.approx(0.5, abs=0.1)


def test_after_full_state_the_high_level_commander_lands_from_where_the_vehicle_is() -> None:
    crazyflies = CflibFleet(np.array([[0.0, 0.0, 1.0, 0.0]]))
    crazyflies.firmware().parameters.set("stabilizer.controller", MELLINGER)
    wire = crazyflies.wire()
    sender, plan = commander(wire), high_level(wire)
    quat, still = identity_quat(), (0.0, 0.0, 0.0)

    def hold(_: float) -> None:
        sender.send_full_state_setpoint((0.3, 0.2, 1.0), still, still, quat, 0.0, 0.0, 0.0)

    crazyflies.fly(4.0, hold)
    np.testing.assert_allclose(crazyflies.pos(), [0.3, 0.2, 1.0], atol=0.03)
    sender.send_notify_setpoint_stop()
    plan.land(0.0, 2.0)
    heights = []
    crazyflies.fly(2.0, lambda _: heights.append(crazyflies.pos()[2]))
    assert np.max(np.abs(np.diff(heights))) < 0.02  # no drop: 10 ms at most at 2 m/s
    crazyflies.fly(2.0)
    np.testing.assert_allclose(crazyflies.pos(), [0.3, 0.2, 0.0], atol=0.05)


def test_an_estimator_fed_by_a_client_flies_as_well_and_lags_by_what_the_client_lags() -> None:
    crazyflies = CflibFleet(np.zeros((1, 4)), build=Build(positioning_deck=False))
    crazyflies.firmware().parameters.set("stabilizer.controller", MELLINGER)
    wire = crazyflies.wire()
    place, plan = localization(wire), high_level(wire)
    crazyflies.fly(0.5, lambda _: place.send_extpos(crazyflies.pos()))
    plan.takeoff(1.0, 2.0)
    crazyflies.fly(4.0, lambda _: place.send_extpose(crazyflies.pos(), crazyflies.swarm.state[0, 6:10]))
    np.testing.assert_allclose(crazyflies.pos(), [0.0, 0.0, 1.0], atol=0.03)
    assert crazyflies.firmware().external.quat == pytest.approx(crazyflies.swarm.state[0, 6:10], abs=1e-6)


def test_a_flow_deck_flies_from_where_the_estimate_began_and_forgets_the_room() -> None:
    crazyflies = CflibFleet(
        np.array([[2.0, -1.0, 0.0, 0.0]]), build=Build(positioning_deck=False, flow_deck=True)
    )
    crazyflies.fly(0.5)
    np.testing.assert_allclose(crazyflies.firmware().rows.pos, 0.0, atol=1e-3)
    sender = commander(crazyflies.wire())
    for rise in np.linspace(0.0, 0.5, 100):
        sender.send_hover_setpoint(0.0, 0.0, 0.0, rise)
        crazyflies.fly(0.01)
    crazyflies.fly(4.0, lambda _: sender.send_hover_setpoint(0.25, 0.0, 0.0, 0.5))
    moved = crazyflies.pos() - [2.0, -1.0, 0.0]
    np.testing.assert_allclose(moved, [1.0, 0.0, 0.5], atol=0.1)  # 0.25 m/s for 4 s, less the start
    np.testing.assert_allclose(
        crazyflies.firmware().rows.pos, moved, atol=1e-3
    )  # exact but for the room's origin
    assert crazyflies.firmware().estimator.variance[0] > 1.0  # where it is in the room, nobody knows


@pytest.mark.parametrize("expires", [False, True])
def test_the_zero_setpoint_of_a_script_that_ended_bars_the_next_ones_take_off_unless_it_expires(
    expires: bool,
) -> None:
    crazyflies = CflibFleet(np.zeros((1, 4)), build=Build(zero_expires=expires))
    crazyflies.fly(0.5)
    commander(crazyflies.wire(0, "first")).send_setpoint(0.0, 0.0, 0.0, 0)  # cflib's close_link
    crazyflies.fly(0.3)
    high_level(crazyflies.wire(0, "second")).takeoff(0.5, 1.0)
    crazyflies.fly(3.0)
    assert crazyflies.pos()[2] == pytest.approx(0.5 if expires else 0.0, abs=0.1)


def test_an_rpyt_setpoint_that_goes_on_after_a_pause_without_thrust_is_still_unlocked() -> None:
    crazyflies = CflibFleet(np.zeros((1, 4)), build=Build(zero_expires=True))
    sender = commander(crazyflies.wire())
    crazyflies.fly(0.5)
    sender.send_setpoint(0.0, 0.0, 0.0, 0)
    crazyflies.fly(1.0)
    crazyflies.fly(1.0, lambda _: sender.send_setpoint(0.0, 0.0, 0.0, 50000))
    assert crazyflies.pos()[2] > 0.2


EXACT = 65535 / CRAZYFLIE_2_0.full_pwm_thrust
"""massThrust [1/N] that makes up for the weight; the stock value leaves 3 % to the loop."""


def under_a_source(aware: bool) -> Array:
    """Return the height of a vehicle that holds 1 m on Mellinger's loop while another hovers 0.5 m above."""
    crazyflies = CflibFleet(np.array([[0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 1.5, 0.0]]), wake=WakeLaw.PAPER)
    rpyt_setpoints = [commander(crazyflies.wire(k)) for k in (0, 1)]
    for k in (0, 1):
        crazyflies.firmware(k).parameters.set("stabilizer.controller", MELLINGER)
        crazyflies.firmware(k).parameters.set("ctrlMel.massThrust", EXACT)
    heights: list[float] = []

    def hold(_: float) -> None:
        eta = crazyflies.swarm.downwash()
        for k, sender in enumerate(rpyt_setpoints):
            acc = -eta[k] if aware else np.zeros(3)
            sender.send_full_state_setpoint(
                (0.0, 0.0, 1.0 + 0.5 * k), (0, 0, 0), acc, identity_quat(), 0, 0, 0
            )
        heights.append(crazyflies.pos(0)[2])

    crazyflies.fly(4.0, hold)
    return np.array(heights)


def test_acc_minus_eta_on_mellingers_loop_takes_the_downwash_out() -> None:
    ignoring, aware = (under_a_source(one) for one in (False, True))
    rms = [float(np.sqrt(np.mean((one - 1.0) ** 2))) for one in (ignoring, aware)]
    assert rms[0] > 0.008  # 0.392 m/s^2 over a stiffness of 37 /s^2 is 1 cm
    assert rms[1] < 0.25 * rms[0]  # what is left is the rotors' lag of 0.07 s at the start


def test_two_vehicles_hear_their_own_commands_only() -> None:
    crazyflies = CflibFleet(np.array([[0.0, 0.0, 0.0, 0.0], [2.0, 0.0, 0.0, 0.0]]))
    crazyflies.fly(0.5)
    high_level(crazyflies.wire(1)).takeoff(1.0, 1.0)
    crazyflies.fly(3.0)
    assert crazyflies.pos(0)[2] == 0.0
    assert crazyflies.pos(1)[2] == pytest.approx(1.0, abs=0.12)


def test_vehicles_that_start_in_the_air_are_held_until_their_first_thrust() -> None:
    crazyflies = CflibFleet(np.array([[0.0, 0.0, 1.0, 0.4]]))
    crazyflies.fly(3.0)
    np.testing.assert_array_equal(crazyflies.pos(), [0.0, 0.0, 1.0])
    sender = commander(crazyflies.wire())
    crazyflies.fly(0.5, lambda _: sender.send_setpoint(0.0, 0.0, 0.0, 0))
    np.testing.assert_array_equal(crazyflies.pos(), [0.0, 0.0, 1.0])
    crazyflies.fly(0.5, lambda _: sender.send_setpoint(0.0, 0.0, 0.0, 20000))
    assert crazyflies.pos()[2] < 0.9
