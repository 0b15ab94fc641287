"""Vehicles whose emulated firmware executes commands move as commanded, and as by CRTP packets."""

import math
import struct
from dataclasses import replace

import numpy as np
import pytest

from q2q_model.vehicle.constants import CRAZYFLIE_2_1
from q2q_sim.crtp.fleet import Fleet
from q2q_sim.firmware.commanded_flight import CommandedFlight
from q2q_sim.firmware.firmware_build import Build
from q2q_sim.loop.closed_loop import FlightOptions, fly
from q2q_sim.plant.body.state_row import QUAT
from q2q_sim.plant.swarm import Swarm
from q2q_sim.scenarios import library
from q2q_sim.scenarios.scenario_document import scenario_from_document

CALM = np.tile([0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0], (1, 1))
"""No moving air, all rotors whole."""
HOVER = CRAZYFLIE_2_1.hover_thrust
STEPS = 5


def swarm() -> Swarm:
    return Swarm(("cf1",), CRAZYFLIE_2_1, np.array([[0.0, 0.0, 1.0, 0.0]]))


def flown(command: tuple[float, float, float, float], ticks: int = 50) -> np.ndarray:
    """Return the state, (21,), after ticks of one command: thrust, roll, pitch, yaw rate."""
    vehicles = swarm()
    flight = CommandedFlight(vehicles, CRAZYFLIE_2_1)
    for _ in range(ticks):
        flight.step(np.tile(command, (STEPS, 1, 1)), CALM)
    return np.array(vehicles.state[0])


def test_a_vehicle_moves_where_it_is_tilted() -> None:
    """Nose down is forwards, right side down is to the right, a positive rate turns to the left."""
    forwards, right, turned = (
        flown(command) for command in ((HOVER, 0.0, 0.1, 0.0), (HOVER, 0.1, 0.0, 0.0), (HOVER, 0.0, 0.0, 1.0))
    )
    assert forwards[0] > 0.02
    assert abs(forwards[1]) < 1e-3
    assert right[1] < -0.02
    assert abs(right[0]) < 1e-3
    yaw = 2.0 * math.atan2(turned[QUAT][2], turned[QUAT][3])
    assert 0.3 < yaw < 0.5  # 0.5 s at 1 rad/s, less the time to turn up
    assert flown((HOVER, 0.0, 0.0, 0.0))[2] == pytest.approx(1.0, abs=2e-3)


def packet(roll: float, pitch: float, thrust: float) -> bytes:
    """Return the RPYT packet of a command, in cflib's signs."""
    pwm = round(thrust / CRAZYFLIE_2_1.full_pwm_thrust * 65535)
    return bytes([0x30]) + struct.pack("<fffH", math.degrees(roll), -math.degrees(pitch), 0.0, pwm)


def test_packets_of_the_same_commands_fly_the_same_way() -> None:
    """By CRTP, commander, supervisor and battery, once armed, a vehicle is within 5 mm of it after 1 s."""
    by_packet, by_command = swarm(), swarm()
    fleet = Fleet(by_packet, CRAZYFLIE_2_1, Build(positioning_deck=True))
    flight, vehicle = CommandedFlight(by_command, CRAZYFLIE_2_1), fleet.vehicles[0]
    vehicle.handle(packet(0.0, 0.0, 0.0))  # unlocks the thrust
    for tick in range(150):
        if tick == 50:  # armed and hovering, both
            by_packet.state[:] = by_command.state
        away = max(tick - 50, 0)
        roll, pitch = 0.15 * math.sin(0.1 * away), 0.1 * math.sin(0.07 * away)
        vehicle.handle(packet(roll, pitch, HOVER))
        fleet.fly(CALM)
        flight.step(np.tile((HOVER, roll, pitch, 0.0), (STEPS, 1, 1)), CALM)
    assert by_command.state[0, :3] == pytest.approx(by_packet.state[0, :3], abs=5e-3)
    assert np.hypot(*by_command.state[0, :2]) > 0.1  # it went somewhere


def test_commands_that_change_within_a_tick_are_taken_step_by_step() -> None:
    """A change below one PWM takes the way of single steps and flies the same, one of 2 % does not."""
    states = []
    for more in (0.0, 1e-9, 0.02 * HOVER):
        vehicles = swarm()
        flight = CommandedFlight(vehicles, CRAZYFLIE_2_1)
        for _ in range(20):
            commands = np.tile((HOVER, 0.05, 0.0, 0.0), (STEPS, 1, 1))
            commands[3:, :, 0] += more
            flight.step(commands, CALM)
        states.append(vehicles.state.copy())
    assert np.array_equal(states[0], states[1])
    assert states[2][0, 2] > states[0][0, 2] + 1e-4


def test_a_scenario_flies_by_its_firmware_to_the_end() -> None:
    """table6_room by the emulated firmware: another flight than by the paper's loop, within 20 cm, too."""
    scenario = replace(library.load("table6_room"), duration=10.0)
    paper, firmware = (
        fly(replace(scenario, attitude=loop), FlightOptions(seed=3)) for loop in ("paper", "firmware")
    )
    for flight in (paper, firmware):
        assert np.linalg.norm(flight.true_pos - flight.ref_pos, axis=-1).max() < 0.2
    assert not np.array_equal(paper.true_pos, firmware.true_pos)


def test_a_document_names_the_loop() -> None:
    document = {"vehicles": {"cf1": [{"pos": [0, 0, 1]}, {"pos": [1, 0, 1]}]}}
    assert scenario_from_document("x", document).attitude == "paper"
    assert scenario_from_document("x", document | {"attitude": "firmware"}).attitude == "firmware"
    with pytest.raises(ValueError, match="attitude"):
        scenario_from_document("x", document | {"attitude": "px4"})
