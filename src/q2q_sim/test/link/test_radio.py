"""Tests of the commands that vehicles apply: delays, losses, the thrust lock and the firmware's watchdog."""

from dataclasses import replace

import numpy as np
import pytest

from q2q_control.radio.link.rpyt_scale import RpytScale, rpyt_rows
from q2q_model.signals.values import SwarmCommand
from q2q_model.vehicle.constants import CRAZYFLIE_2_0, Vehicle
from q2q_sim.link.radio import Radio, RadioParams, command_values
from q2q_sim.link.radio_kernel import round_packets

TICK_NS, STEP_NS, STEPS = 10_000_000, 2_000_000, 5
HOVER = 0.33
ROW = np.array([0])
STRONG = replace(CRAZYFLIE_2_0, thrust_max=0.6, full_pwm_thrust=0.66)
CLEAR = np.zeros(50, dtype=np.bool_)


def _command(thrust: float, roll: float = 0.0, n: int = 1) -> np.ndarray:
    command = SwarmCommand(
        t=0.0,
        names=tuple(f"cf{i + 1}" for i in range(n)),
        thrust=np.full(n, thrust),
        roll=np.full(n, roll),
        pitch=np.full(n, -0.5 * roll),
        yaw_rate=np.full(n, 0.25),
        status=np.zeros(n, dtype=np.uint8),
    )
    return command_values(command)


def _radio(params: RadioParams, n: int = 1, seed: int = 0, vehicle: Vehicle = STRONG) -> Radio:
    return Radio(params, np.full(n, HOVER), vehicle, seed)


def _tick(radio: Radio, k: int) -> np.ndarray:
    return radio.applied(k * TICK_NS, STEP_NS, STEPS)[:, 0]


def test_a_perfect_radio_hands_over_what_was_asked_at_once() -> None:
    radio = _radio(RadioParams())
    radio.send(0, ROW, _command(0.4, roll=0.1), CLEAR)
    np.testing.assert_array_equal(_tick(radio, 0), [[0.4, 0.1, -0.05, 0.25]] * STEPS)


@pytest.mark.parametrize(("latency", "steps"), [(0.002, 1), (0.009, 5), (0.026, 13)])
def test_a_command_is_obeyed_from_the_first_step_after_its_latency(latency: float, steps: int) -> None:
    radio = _radio(RadioParams(latency=latency))
    radio.send(0, ROW, _command(0.5), CLEAR)
    thrust = np.concatenate([_tick(radio, k)[:, 0] for k in range(4)])
    np.testing.assert_array_equal(thrust, [HOVER] * steps + [0.5] * (20 - steps))


def test_without_packets_it_levels_after_half_a_second_and_cuts_after_two() -> None:
    radio = _radio(RadioParams())
    radio.send(0, ROW, _command(0.5, roll=0.2), CLEAR)
    first = {"tilted": 0, "level": 0, "cut": 0}
    for k in range(250):
        applied = _tick(radio, k)[0]
        kind = "cut" if applied[0] == 0.0 else "level" if applied[1] == 0.0 else "tilted"
        assert applied[0] in {0.0, 0.5}  # thrust stays until it is cut
        first[kind] += 1
    # the watchdog is looked at once per tick: the tick after 0.5 s and after 2 s
    assert first == {"tilted": 51, "level": 150, "cut": 49}


def test_after_a_cut_thrust_stays_locked_until_a_packet_without_thrust() -> None:
    radio = _radio(RadioParams())
    radio.send(0, ROW, _command(0.5), CLEAR)
    _tick(radio, 0)
    _tick(radio, 300)
    for k, thrust, applied in ((301, 0.5, 0.0), (302, 0.0, 0.0), (303, 0.5, 0.5)):
        radio.send(k * TICK_NS, ROW, _command(thrust), CLEAR)
        assert _tick(radio, k)[-1, 0] == applied


def test_a_locked_vehicle_keeps_its_motors_off_until_unlocked() -> None:
    radio = _radio(RadioParams(unlocked=False))
    assert _tick(radio, 0)[0, 0] == 0.0
    for k, thrust, applied in ((1, 0.4, 0.0), (2, 0.0, 0.0), (3, 0.4, 0.4)):
        radio.send(k * TICK_NS, ROW, _command(thrust), CLEAR)
        assert _tick(radio, k)[-1, 0] == applied


def test_lost_packets_leave_the_last_command_and_are_as_many_as_said() -> None:
    n, ticks, loss = 50, 200, 0.3
    radio = _radio(RadioParams(loss=loss), n=n)
    received = 0
    for k in range(ticks):
        radio.send(k * TICK_NS, np.arange(n), _command(0.1 + 0.001 * k, n=n), CLEAR)
        received += int((radio.applied(k * TICK_NS, STEP_NS, STEPS)[-1, :, 0] == 0.1 + 0.001 * k).sum())
    share = received / (n * ticks)
    assert share == pytest.approx(1.0 - loss, abs=4.0 * np.sqrt(loss * (1.0 - loss) / (n * ticks)))  # 4 sigma


def test_a_slower_radio_sends_as_many_packets_as_it_can() -> None:
    radio = _radio(RadioParams(rate=60.0))
    received = set()
    for k in range(1000):
        radio.send(k * TICK_NS, ROW, _command(0.1 + 0.0001 * k), CLEAR)
        received.add(float(_tick(radio, k)[-1, 0]))
    assert len(received) == pytest.approx(600, abs=1)


def test_quantised_packets_carry_whole_pwm_and_32_bit_degrees() -> None:
    radio = _radio(RadioParams(quantised=True), vehicle=CRAZYFLIE_2_0)
    radio.send(0, ROW, _command(0.4321, roll=0.1), CLEAR)
    applied = _tick(radio, 0)[0]
    assert applied[0] == pytest.approx(58995 / 65535 * 0.48)  # 0.4321 / 0.48 * 65535 = 58995.15
    assert applied[1] == pytest.approx(0.1, rel=2.0**-24)
    assert applied[1] != 0.1
    radio.send(TICK_NS, ROW, _command(0.48 * 999 / 65535), CLEAR)
    assert _tick(radio, 1)[0, 0] == 0.0  # below the firmware's least thrust


def test_a_packet_is_read_as_the_degrees_and_pwm_of_a_real_radio() -> None:
    rng, full = np.random.default_rng(0), 0.48
    values = np.stack([rng.uniform(-0.1, 0.5, 500), *rng.normal(0.0, 0.3, (3, 500))])
    names = tuple(f"cf{k}" for k in range(500))
    command = SwarmCommand(0.0, names, *values, status=np.zeros(500, dtype=np.uint8))
    read = np.empty((4, 500))
    round_packets(values, full, read)
    pitch, roll, yaw_rate, pwm = rpyt_rows(command, RpytScale(full)).T
    np.testing.assert_array_equal(read[0], np.where(pwm < 1000, 0.0, pwm) / 65535 * full)
    for angle, degrees in zip(read[1:], (roll, pitch, yaw_rate), strict=True):
        np.testing.assert_array_equal(angle, np.radians(degrees.astype(np.float32).astype(float)))


def test_no_rpyt_setpoint_carries_more_than_60000_pwm() -> None:
    for quantised in (False, True):
        radio = _radio(RadioParams(quantised=quantised), vehicle=CRAZYFLIE_2_0)
        radio.send(0, ROW, _command(0.47), CLEAR)
        assert _tick(radio, 0)[0, 0] == pytest.approx(60000 / 65535 * 0.48)


def test_a_burst_for_some_vehicles_leaves_the_others_alone() -> None:
    radio = _radio(RadioParams(), n=3)
    radio.send(0, np.array([2, 0]), _command(0.5, n=2), CLEAR)
    np.testing.assert_array_equal(radio.applied(0, STEP_NS, STEPS)[0, :, 0], [0.5, HOVER, 0.5])


def test_a_jammed_vehicle_hears_nothing_and_the_others_all() -> None:
    radio = _radio(RadioParams(), n=3)
    radio.send(0, np.arange(3), _command(0.5, n=3), np.array([False, True, False]))
    np.testing.assert_array_equal(radio.applied(0, STEP_NS, STEPS)[0, :, 0], [0.5, HOVER, 0.5])
