"""Every setpoint that cflib encodes means the same to the vehicle: signs and units, packet by packet."""

import math
import struct

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cflib_fleet import CflibFleet
from q2q_model.geometry.quaternion32 import compress_quat, decompress_quat
from q2q_model.geometry.rotations import quat_from_euler
from q2q_sim.firmware.commander.setpoint import STOP, Mode, Setpoint

pytest.importorskip("cflib", reason="cflib is not installed: requirements/dev.txt has it")

from cflib.crazyflie.commander import Commander
from cflib.utils.encoding import compress_quaternion, decompress_quaternion

Numbers = tuple[float, ...]

ALIKE = 1.0 - 6 * 0.0007**2
"""Cosine of half the angle between attitudes: three parts are off by 0.0007, the largest by thrice that."""
MILLI = 1.001e-3
"""cflib cuts thousandths off."""


def commanded(grounded: CflibFleet) -> Setpoint:
    return grounded.firmware().commander.setpoint


def test_thrust_stays_locked_until_a_packet_without_thrust_has_come(grounded: CflibFleet) -> None:
    commander = Commander(grounded.wire())
    commander.send_setpoint(0.0, 0.0, 0.0, 30000)
    assert commanded(grounded).thrust_pwm == 0.0
    commander.send_setpoint(0.0, 0.0, 0.0, 0)
    commander.send_setpoint(0.0, 0.0, 0.0, 30000)
    assert commanded(grounded).thrust_pwm == 30000.0


@pytest.mark.parametrize(("sent", "flown"), [(999, 0.0), (1000, 1000.0), (60000, 60000.0), (65535, 60000.0)])
def test_thrust_below_1000_is_none_and_above_60000_is_60000(
    grounded: CflibFleet, sent: int, flown: float
) -> None:
    commander = Commander(grounded.wire())
    commander.send_setpoint(0.0, 0.0, 0.0, 0)
    commander.send_setpoint(0.0, 0.0, 0.0, sent)
    assert commanded(grounded).thrust_pwm == flown


def test_rpyt_turns_the_signs_of_pitch_and_yaw_rate(grounded: CflibFleet) -> None:
    Commander(grounded.wire()).send_setpoint(3.0, 4.0, 5.0, 0)
    one = commanded(grounded)
    assert (one.roll, one.pitch, one.yaw, one.x, one.z) == (
        Mode.ABS, Mode.ABS, Mode.VELOCITY, Mode.DISABLE, Mode.DISABLE,
    )  # fmt: skip
    assert one.attitude_deg == (3.0, -4.0, 0.0)  # legacy pitch is nose up, cflib's is nose down
    assert one.rate_deg[2] == -5.0


@pytest.mark.parametrize(
    ("parameter", "value", "expected"),
    [
        ("flightmode.stabModeRoll", 0, {"roll": Mode.VELOCITY, "rate_deg": (3.0, 0.0, -5.0)}),
        ("flightmode.stabModePitch", 0, {"pitch": Mode.VELOCITY, "rate_deg": (0.0, -4.0, -5.0)}),
        ("flightmode.stabModeYaw", 1, {"yaw": Mode.ABS, "attitude_deg": (3.0, -4.0, 5.0)}),
        ("flightmode.althold", 1, {"z": Mode.VELOCITY, "vel": (0.0, 0.0, 0.0)}),
        ("flightmode.poshold", 1, {"x": Mode.VELOCITY, "vel": (-4.0 / 30.0, 0.1, 0.0)}),
        ("flightmode.posSet", 1, {"x": Mode.ABS, "pos": (4.0, 3.0, 32.767), "attitude_deg": (0.0, 0.0, 5.0)}),
    ],
)
def test_flightmode_parameters_change_what_an_rpyt_setpoint_means(
    grounded: CflibFleet, parameter: str, value: float, expected: dict[str, object]
) -> None:
    grounded.firmware().parameters.set(parameter, value)
    Commander(grounded.wire()).send_setpoint(3.0, 4.0, 5.0, 32767)
    for name, demanded in expected.items():
        assert getattr(commanded(grounded), name) == pytest.approx(demanded)


@settings(
    deadline=None,
)  # pilot_of is a class
@given(
    numbers=st.lists(st.floats(-30.0, 30.0), min_size=12, max_size=12),
    angles=st.tuples(st.floats(-3.0, 3.0), st.floats(-1.5, 1.5), st.floats(-3.0, 3.0)),
)
def test_full_state_carries_every_number_in_its_place(numbers: list[float], angles: Numbers) -> None:
    crazyflies = CflibFleet(np.zeros((1, 4)))
    pos, vel, acc, rates = (numbers[k : k + 3] for k in (0, 3, 6, 9))
    quat = quat_from_euler(*angles)
    Commander(crazyflies.wire()).send_full_state_setpoint(pos, vel, acc, quat, *rates)
    one = commanded(crazyflies)
    np.testing.assert_allclose(one.pos, pos, atol=MILLI)
    np.testing.assert_allclose(one.vel, vel, atol=MILLI)
    np.testing.assert_allclose(one.acc, acc, atol=MILLI)
    # rad/s, whatever cflib calls them
    np.testing.assert_allclose(np.radians(one.rate_deg), rates, atol=MILLI)
    assert abs(np.dot(one.attitude_quat, quat)) > ALIKE


def test_position_velocity_hover_distance_manual_and_stop_are_read(grounded: CflibFleet) -> None:
    commander = Commander(grounded.wire())
    commander.send_position_setpoint(1.0, 2.0, 3.0, 40.0)
    assert commanded(grounded) == Setpoint(
        x=Mode.ABS, y=Mode.ABS, z=Mode.ABS, yaw=Mode.ABS, pos=(1.0, 2.0, 3.0), attitude_deg=(0.0, 0.0, 40.0)
    )
    move = Mode.VELOCITY
    commander.send_velocity_world_setpoint(1.0, 2.0, 3.0, 40.0)
    assert commanded(grounded) == Setpoint(
        x=move, y=move, z=move, yaw=move, vel=(1.0, 2.0, 3.0), rate_deg=(0.0, 0.0, 40.0)
    )
    commander.send_hover_setpoint(1.0, 2.0, 40.0, 3.0)
    assert commanded(grounded) == Setpoint(
        x=move, y=move, z=Mode.ABS, yaw=move, pos=(0.0, 0.0, 3.0), vel=(1.0, 2.0, 0.0),
        rate_deg=(0.0, 0.0, 40.0), velocity_body=True,
    )  # fmt: skip
    commander.send_zdistance_setpoint(1.0, 2.0, 40.0, 3.0)
    assert commanded(grounded) == Setpoint(
        roll=Mode.ABS, pitch=Mode.ABS, yaw=move, z=Mode.ABS, pos=(0.0, 0.0, 3.0),
        attitude_deg=(1.0, 2.0, 0.0), rate_deg=(0.0, 0.0, 40.0),
    )  # fmt: skip
    commander.send_setpoint_manual(1.0, 2.0, 40.0, 50.0, rate=True)
    one = commanded(grounded)
    assert (one.roll, one.pitch, one.rate_deg, one.thrust_pwm) == (move, move, (1.0, -2.0, 40.0), 35000.0)
    commander.send_setpoint_manual(1.0, 2.0, 40.0, 50.0, rate=False)
    assert commanded(grounded).attitude_deg == (1.0, -2.0, 0.0)
    commander.send_stop_setpoint()
    assert commanded(grounded) == STOP


def test_an_rpyt_setpoint_after_a_hover_packet_moves_in_the_bodys_frame_under_poshold(
    grounded: CflibFleet,
) -> None:
    grounded.firmware().parameters.set("flightmode.poshold", 1)
    commander = Commander(grounded.wire())
    commander.send_setpoint(3.0, 6.0, 5.0, 0)
    assert not commanded(grounded).velocity_body
    commander.send_hover_setpoint(1.0, 2.0, 40.0, 3.0)
    commander.send_setpoint(3.0, 6.0, 5.0, 0)
    assert commanded(grounded) == Setpoint(
        x=Mode.VELOCITY, y=Mode.VELOCITY, yaw=Mode.VELOCITY, pos=(0.0, 0.0, 3.0), vel=(-0.2, 0.1, 0.0),
        rate_deg=(0.0, 0.0, -5.0), velocity_body=True,
    )  # fmt: skip
    commander.send_stop_setpoint()
    commander.send_setpoint(3.0, 6.0, 5.0, 0)
    assert not commanded(grounded).velocity_body


@pytest.mark.parametrize("kind", [12, 99, 255])
def test_setpoints_of_unknown_types_stop_the_motors(grounded: CflibFleet, kind: int) -> None:
    Commander(grounded.wire()).send_position_setpoint(1.0, 2.0, 3.0, 40.0)
    grounded.fleet.vehicles[0].handle(bytes([0x7C, kind]))
    assert commanded(grounded) == STOP


def test_radio_control_pulses_are_angles_or_by_the_fifth_channel_rates(grounded: CflibFleet) -> None:
    channels = (1750, 1250, 2000, 1500)
    grounded.fleet.vehicles[0].handle(struct.pack("<BBB4H", 0x7C, 3, 0, *channels))
    assert commanded(grounded) == Setpoint(
        roll=Mode.ABS, pitch=Mode.ABS, yaw=Mode.VELOCITY, attitude_deg=(-25.0, 25.0, 0.0),
        rate_deg=(0.0, 0.0, -400.0), thrust_pwm=32767.5,
    )  # fmt: skip
    grounded.firmware().parameters.set("cppm.rateRoll", 100.0)
    grounded.fleet.vehicles[0].handle(struct.pack("<BBB5H", 0x7C, 3, 1, *channels, 1499))
    one = commanded(grounded)
    assert (one.roll, one.pitch, one.attitude_deg) == (Mode.VELOCITY, Mode.VELOCITY, (0.0, 0.0, 0.0))
    assert one.rate_deg == (-50.0, 360.0, -400.0)


def test_old_setpoints_of_the_same_kind_turn_the_other_way(grounded: CflibFleet) -> None:
    wire = grounded.wire()
    wire.version = 8
    with pytest.warns(DeprecationWarning, match="legacy"):
        Commander(wire).send_velocity_world_setpoint(1.0, 2.0, 3.0, 40.0)
    assert wire.sent[-1][1] == 1  # the old type
    # cflib turned the sign, the vehicle turns it back
    assert commanded(grounded).rate_deg == (0.0, 0.0, 40.0)


@settings(deadline=None)
@given(st.tuples(*[st.floats(-1.0, 1.0)] * 4).filter(lambda q: math.hypot(*q) > 0.1))
def test_quaternions_are_packed_and_unpacked_as_cflib_does(parts: Numbers) -> None:
    quat = np.array(parts) / math.hypot(*parts)
    x, y, z, w = quat.tolist()
    mine = compress_quat((x, y, z, w))
    np.testing.assert_allclose(decompress_quat(mine), decompress_quaternion(mine), atol=1e-12)
    assert abs(np.dot(decompress_quat(compress_quaternion(quat)), quat)) > ALIKE
    assert abs(np.dot(decompress_quaternion(mine), quat)) > ALIKE


def test_notify_setpoint_stop_gives_way_to_the_high_level_commander(grounded: CflibFleet) -> None:
    commander = Commander(grounded.wire())
    commander.send_position_setpoint(0.0, 0.0, 1.0, 0.0)
    assert grounded.firmware().commander.priority == 2
    commander.send_notify_setpoint_stop()
    assert grounded.firmware().commander.priority == 1
