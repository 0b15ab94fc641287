"""Log blocks, as cflib sets them up and reads them."""

import math
import struct

import numpy as np
import pytest
from crtp_asked import ask

from cflib_fleet import CflibFleet
from q2q_model.geometry.rotations import quat_from_euler, rotate_inverse
from q2q_sim.crtp.tables.log_toc import VARIABLES
from q2q_sim.crtp.tables.number_types import TYPES
from q2q_sim.firmware.commander.setpoint import Mode, Setpoint
from q2q_sim.firmware.controllers.columns import ATTITUDE_SETPOINT
from q2q_sim.firmware.firmware_build import Build
from q2q_sim.firmware.parameters.parameter_table import TABLE
from q2q_sim.plant.body.state_row import QUAT, RATE, VEL
from q2q_sim.sensors.range_finder import NOTHING_MM, RoomBox

LOG_CONTROL, LOG_DATA = b"\x5d", 0x5E


def log_id(name: str) -> int:
    return next(k for k, one in enumerate(VARIABLES) if f"{one.group}.{one.name}" == name)


def block(crazyflies: CflibFleet, number: int, names: list[tuple[str, int]], period: int) -> None:
    """Make and start a block; `names` with the type numbers to fetch them as, the period in 10 ms."""
    operations = b"".join(bytes([kind]) + struct.pack("<H", log_id(name)) for name, kind in names)
    assert ask(crazyflies, LOG_CONTROL + bytes([6, number]) + operations) == bytes([6, number, 0])
    assert ask(crazyflies, LOG_CONTROL + bytes([3, number, period])) == bytes([3, number, 0])


def logged(crazyflies: CflibFleet, number: int) -> list[tuple[int, bytes]]:
    """Return time [ms] and values of every packet of a block."""
    data = [
        one.datagram for one in crazyflies.out if one.datagram[0] == LOG_DATA and one.datagram[1] == number
    ]
    return [(int.from_bytes(one[2:5], "little"), one[5:]) for one in data]


def test_blocks_come_at_their_periods_and_carry_the_state_in_the_types_asked_for(
    grounded: CflibFleet,
) -> None:
    grounded.swarm.state[0, :3] = 1.5, -2.25, 0.0
    block(grounded, 1, [("stateEstimate.x", 7), ("stateEstimateZ.y", 5), ("stateEstimate.y", 8)], 1)
    block(grounded, 2, [("acc.z", 7), ("pm.vbatMV", 2)], 5)
    begin = grounded.firmware().now_ms
    grounded.fly(1.0)
    fast, slow = logged(grounded, 1), logged(grounded, 2)
    assert [t - begin for t, _ in fast] == list(range(10, 1001, 10))
    assert [t - begin for t, _ in slow] == list(range(50, 1001, 50))
    x, y_mm, y = struct.unpack("<fhe", fast[-1][1])
    assert (x, y_mm, y) == (pytest.approx(1.5), pytest.approx(-2250, abs=1), pytest.approx(-2.25))
    weight, volt = struct.unpack("<fH", slow[-1][1])
    assert weight == pytest.approx(1.0)  # at rest on the ground it reads gravity, upwards
    assert volt == pytest.approx(4200, abs=1)


@pytest.mark.parametrize("start", [b"\x03\x01\0", b"\x08\x01\0\0"])
def test_a_start_with_period_0_sends_a_block_once(grounded: CflibFleet, start: bytes) -> None:
    """As logStartBlock of the firmware's log.c, which then leaves the block's timer alone."""
    block(grounded, 1, [("acc.z", 7)], 0)
    begin = grounded.firmware().now_ms
    grounded.fly(0.1)
    assert [t - begin for t, _ in logged(grounded, 1)] == [10]
    assert struct.unpack("<f", logged(grounded, 1)[0][1]) == (pytest.approx(1.0),)  # gravity, at rest
    assert ask(grounded, LOG_CONTROL + b"\x03\x01\x05")[-1] == 0  # every 50 ms
    grounded.out.clear()
    assert ask(grounded, LOG_CONTROL + start)[-1] == 0
    begin = grounded.firmware().now_ms
    grounded.fly(0.1)
    assert [t - begin for t, _ in logged(grounded, 1)] == [10, 50, 100]
    assert ask(grounded, LOG_CONTROL + b"\x04\x01")[-1] == 0
    grounded.out.clear()
    assert ask(grounded, LOG_CONTROL + start)[-1] == 0
    grounded.fly(0.1)
    assert len(logged(grounded, 1)) == 1


def test_stopped_and_deleted_blocks_are_silent_and_their_numbers_are_free(grounded: CflibFleet) -> None:
    block(grounded, 1, [("acc.x", 7)], 1)
    assert ask(grounded, LOG_CONTROL + b"\x04\x01") == b"\x04\x01\x00"
    grounded.fly(0.1)
    assert logged(grounded, 1) == []
    assert ask(grounded, LOG_CONTROL + b"\x02\x01") == b"\x02\x01\x00"
    assert ask(grounded, LOG_CONTROL + b"\x02\x01") == b"\x02\x01\x02"
    block(grounded, 1, [("acc.x", 7)], 1)


def test_blocks_too_many_too_long_twice_or_of_unknown_variables_are_refused(grounded: CflibFleet) -> None:
    seven = b"".join(b"\x07" + struct.pack("<H", k) for k in range(7))
    assert ask(grounded, LOG_CONTROL + b"\x06\x01" + seven)[-1] == 7  # 28 bytes: E2BIG
    assert ask(grounded, LOG_CONTROL + b"\x06\x01")[-1] == 17  # EEXIST
    assert ask(grounded, LOG_CONTROL + b"\x06\x02\x07\xf0\xff")[-1] == 2  # ENOENT
    ask(grounded, LOG_CONTROL + b"\x05")
    assert [ask(grounded, LOG_CONTROL + bytes([6, k]))[-1] for k in range(17)] == [0] * 16 + [12]
    assert ask(grounded, LOG_CONTROL + b"\x07\x63\x07\0\0")[-1] == 2
    assert ask(grounded, LOG_CONTROL + b"\x63\x00")[-1] == 8


def test_every_variable_can_be_logged(grounded: CflibFleet) -> None:
    for k in range(len(VARIABLES)):
        ask(grounded, LOG_CONTROL + b"\x05")
        assert ask(grounded, LOG_CONTROL + bytes([6, 1, 7]) + struct.pack("<H", k))[-1] == 0
        ask(grounded, LOG_CONTROL + b"\x03\x01\x01")
        grounded.out.clear()
        grounded.fly(0.02)
        values = [struct.unpack("<f", data)[0] for _, data in logged(grounded, 1)]
        assert values
        assert np.isfinite(values).all(), VARIABLES[k]


def test_everything_that_crazyswarm2_logs_and_sets_by_default_is_there() -> None:
    logged_there = """stateEstimate.x stateEstimate.y stateEstimate.z stabilizer.roll
        stabilizer.pitch stabilizer.yaw kalman.statePX kalman.statePY kalman.statePZ gyro.x gyro.y gyro.z
        supervisor.info pm.vbatMV pm.vbat pm.state radio.rssi radio.numRxBc radio.numRxUc"""
    set_there = """commander.enHighLevel stabilizer.estimator stabilizer.controller locSrv.extPosStdDev
        locSrv.extQuatStdDev kalman.resetEstimation kalman.initialX kalman.initialY kalman.initialZ
        ring.effect"""
    assert set(logged_there.split()) <= {f"{one.group}.{one.name}" for one in VARIABLES}
    assert set(set_there.split()) <= {one.name for one in TABLE}


def test_the_logs_of_a_moving_vehicle_have_the_firmwares_signs(grounded: CflibFleet) -> None:
    quat = quat_from_euler(0.1, 0.2, 0.3)
    grounded.swarm.state[0, :13] = 1.0, 2.0, 3.0, 0.5, -0.4, 0.3, *quat, 0.7, 0.8, 0.9
    values = {f"{one.group}.{one.name}": one.read(grounded.firmware()) for one in VARIABLES}
    degrees = [values[f"stateEstimate.{name}"] for name in ("roll", "pitch", "yaw")]
    np.testing.assert_allclose(degrees, np.degrees([0.1, -0.2, 0.3]))  # legacy pitch: nose up
    np.testing.assert_allclose([values[f"gyro.{axis}"] for axis in "xyz"], np.degrees([0.7, 0.8, 0.9]))
    rates = [values[f"stateEstimateZ.rate{name}"] for name in ("Roll", "Pitch", "Yaw")]
    np.testing.assert_allclose(rates, [700.0, -800.0, 900.0])
    body = rotate_inverse(quat, np.array([0.5, -0.4, 0.3]))
    np.testing.assert_allclose([values[f"kalman.stateP{axis}"] for axis in "XYZ"], body)
    np.testing.assert_allclose([values[f"stateEstimateZ.{axis}"] for axis in "xyz"], [1e3, 2e3, 3e3])


def test_logs_of_the_cascade_are_what_it_is_asked_for_and_asks_for() -> None:
    crazyflies = CflibFleet(np.array([[0.0, 0.0, 1.0, math.pi / 2]]))
    expected = Setpoint(
        x=Mode.ABS, y=Mode.ABS, z=Mode.ABS, yaw=Mode.ABS, pos=(0.3, 0.1, 1.2), attitude_deg=(0.0, 0.0, 90.0)
    )
    crazyflies.fly(1.0)  # arms
    crazyflies.fly(0.05, crazyflies.hold(expected))
    log = {f"{one.group}.{one.name}": one.read(crazyflies.firmware()) for one in VARIABLES}
    # turned to the left by 90 degrees: the vehicle's ahead is y, its left is -x
    np.testing.assert_allclose([log[f"posCtl.target{axis}"] for axis in "XYZ"], [0.1, -0.3, 1.2], atol=1e-3)
    x, y, z = crazyflies.pos()
    np.testing.assert_allclose(
        [log[f"posCtl.targetV{axis}"] for axis in "XY"], [2 * (0.1 - y), -2 * (0.3 - x)], atol=2e-3
    )
    assert log["posCtl.targetVZ"] == pytest.approx(2 * (1.2 - z), rel=0.05)  # zKp, and a little of zKi
    assert log["controller.pitch"] < -1.0  # legacy: nose down to go ahead
    assert log["controller.roll"] > 1.0  # right side down to go right
    assert log["controller.yaw"] == pytest.approx(90.0, abs=0.1)
    rate = 6.0 * (log["controller.roll"] - log["stabilizer.roll"])  # roll_kp, and a little of roll_ki
    assert log["controller.rollRate"] == pytest.approx(rate, rel=0.2)
    assert log["controller.cmd_thrust"] == log["controller.actuatorThrust"] > 36000.0
    qw, qx, qy, qz = (log[f"kalman.q{k}"] for k in range(4))
    np.testing.assert_allclose([qx, qy, qz, qw], crazyflies.swarm.state[0, QUAT])
    force = [log[f"acc.{axis}"] for axis in "xyz"]
    assert log["supervisor.accNorm"] == pytest.approx(math.hypot(*force))


def test_feed_forward_of_the_velocity_tilts_by_itself() -> None:
    ahead = Setpoint(
        x=Mode.VELOCITY, y=Mode.VELOCITY, z=Mode.ABS, yaw=Mode.ABS, pos=(0, 0, 1.0), vel=(0.2, 0.0, 0.0)
    )
    pitch = []
    for feed in (0.0, 10.0):
        crazyflies = CflibFleet(np.array([[0.0, 0.0, 1.0, 0.0]]))
        crazyflies.firmware().parameters.set("velCtlPid.vxKFF", feed)
        crazyflies.fly(1.0)  # arms
        crazyflies.fly(0.01, crazyflies.hold(ahead))
        pitch.append(crazyflies.firmware().rows.memory[ATTITUDE_SETPOINT + 1])
    assert pitch[1] - pitch[0] == pytest.approx(-10.0 * 0.2)


def test_the_flow_is_that_of_the_ground_below_by_velocity_and_rates_of_the_body(grounded: CflibFleet) -> None:
    blind = {one.read(grounded.firmware()) for one in VARIABLES if one.group in {"kalman_pred", "motion"}}
    assert blind == {0.0}  # without a deck
    crazyflies = CflibFleet(np.zeros((1, 4)), build=Build(decks=("bcFlow2",)))
    state = crazyflies.swarm.state
    for height, scale in ((2.0, 0.5), (0.02, 10.0)):  # the filter divides by no less than 0.1 m
        state[0, 2], state[0, VEL], state[0, RATE] = height, (0.5, -0.3, 0.1), (0.4, -0.2, 1.0)
        state[0, QUAT] = quat_from_euler(0.0, 0.0, math.pi / 2)  # ahead is y
        read = {one.name: one.read for one in VARIABLES if one.group == "kalman_pred"}
        flow = [read[name](crazyflies.firmware()) for name in ("predNX", "predNY")]
        np.testing.assert_allclose(flow, 0.35 / 0.71674 * np.array([-0.3 * scale + 0.2, -0.5 * scale + 0.4]))
        assert flow == [read[name](crazyflies.firmware()) for name in ("measNX", "measNY")]
        turned = {one.name: one.read(crazyflies.firmware()) for one in VARIABLES if one.group == "motion"}
        assert turned == {"deltaX": pytest.approx(-10.0 * flow[1]), "deltaY": pytest.approx(-10.0 * flow[0])}


def test_the_barometer_reads_the_pressure_of_the_height(grounded: CflibFleet) -> None:
    grounded.swarm.state[0, 2] = 8.0
    read = {one.name: one.read(grounded.firmware()) for one in VARIABLES if one.group == "baro"}
    height = ((1015.7 / read["pressure"]) ** 0.1902630958 - 1.0) * (25.0 + 273.15) / 0.0065
    assert (read["asl"], height) == (pytest.approx(8.0), pytest.approx(8.0))
    assert 1015.7 - read["pressure"] == pytest.approx(8.0 * 0.118, rel=0.02)  # 11.8 Pa a metre at 25 deg C


@pytest.mark.parametrize("height", [298.15 / -0.0065, -50e3, -3e38, math.nan])
def test_a_height_without_a_pressure_is_logged_as_not_a_number(grounded: CflibFleet, height: float) -> None:
    """An external position in millimetres ended the room of all vehicles: the pressure was complex."""
    grounded.swarm.state[0, 2] = height
    (pressure,) = (one for one in VARIABLES if (one.group, one.name) == ("baro", "pressure"))
    sent = TYPES[pressure.kind].packed(pressure.read(grounded.firmware()))
    assert math.isnan(struct.unpack("<f", sent)[0])


def test_ranges_are_those_along_the_body_axes_to_the_walls_and_0_without_a_deck() -> None:
    box = RoomBox(3.0, 2.0, 2.5)
    looking = Build(decks=("bcMultiranger", "bcZRanger2"), room=box)
    crazyflies = CflibFleet(np.array([[1.1, 0.5, 1.0, math.pi / 2]]), build=looking)  # looks along y
    names = ("front", "back", "left", "right", "up", "zrange")

    def ranges(one: CflibFleet) -> list[float]:
        log = {variable.name: variable for variable in VARIABLES if variable.group == "range"}
        assert {variable.kind for variable in log.values()} == {"uint16"}
        return [log[name].read(one.firmware()) for name in names]

    np.testing.assert_allclose(ranges(crazyflies), [1500, 2500, NOTHING_MM, 1900, 1500, 1000])  # left: 4.1 m
    crazyflies.swarm.state[0, QUAT] = quat_from_euler(0.0, math.radians(60.0), 0.0)  # nose down
    down, slant = 1.0 / math.cos(math.radians(60.0)), 1.0 / math.cos(math.radians(30.0))
    front, *_, zrange = ranges(crazyflies)
    np.testing.assert_allclose([front, zrange], [1e3 * slant, 1e3 * down])  # both end on the floor
    assert ranges(CflibFleet(np.array([[1.0, 0.5, 1.0, 0.0]]))) == [0.0] * 6
    only_down = CflibFleet(np.array([[1.0, 0.5, 1.0, 0.0]]), build=Build(decks=("bcFlow2",)))
    assert ranges(only_down) == [0.0] * 5 + [1000.0]
