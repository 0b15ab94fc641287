"""Tables, parameters, log blocks and memory, as cflib reads and writes them."""

import math
import struct
from dataclasses import replace

import numpy as np
import pytest

from q2q_model.geometry.rotations import quat_from_euler, rotate_inverse
from q2q_sim.crtp.fleet_room import CrtpRoomParams
from q2q_sim.crtp.pilot import Pilot
from q2q_sim.crtp.ports import parameters
from q2q_sim.crtp.tables import log_table
from q2q_sim.crtp.tables.contents import Contents, Entry
from q2q_sim.crtp.tables.log_table import VARIABLES
from q2q_sim.firmware.commander.setpoint import Mode, Setpoint
from q2q_sim.firmware.controllers.columns import ATTITUDE_SETPOINT
from q2q_sim.firmware.firmware import Build
from q2q_sim.firmware.parameters.parameter_table import TABLE
from q2q_sim.plant.quadcopter import QUAT

pytest.importorskip("cflib", reason="cflib is not installed: requirements/dev.txt has it")

from cflib.crazyflie.log import LogTocElement
from cflib.crazyflie.param import Param, ParamTocElement

PARAM_READ, PARAM_WRITE, PARAM_MISC = b"\x2d", b"\x2e", b"\x2f"
LOG_CONTROL, LOG_DATA = b"\x5d", 0x5E


def ask(pilot: Pilot, datagram: bytes) -> bytes:
    (answer,) = pilot.fleet.vehicles[0].handle(datagram)
    assert answer[0] & 0xF3 == datagram[0] & 0xF3  # same port and channel
    return answer[1:]


def param_id(name: str) -> int:
    return next(k for k, one in enumerate(TABLE) if one.name == name)


def log_id(name: str) -> int:
    return next(k for k, one in enumerate(VARIABLES) if f"{one.group}.{one.name}" == name)


@pytest.mark.parametrize(
    ("port", "element", "count"), [(5, LogTocElement, len(VARIABLES)), (2, ParamTocElement, len(TABLE))]
)
def test_every_entry_of_a_table_is_what_cflib_reads(
    grounded: Pilot, port: int, element: type, count: int
) -> None:
    info = ask(grounded, bytes([port << 4 | 0x0C, 3]))
    output, crc = struct.unpack("<HI", info[1:7])
    assert output == count
    assert crc == (log_table if port == 5 else parameters).CONTENTS.crc
    for number in range(count):
        item = ask(grounded, bytes([port << 4 | 0x0C, 2]) + struct.pack("<H", number))
        assert struct.unpack("<H", item[1:3])[0] == number
        read = element(number, bytearray(item[3:]))
        mine = VARIABLES[number] if port == 5 else TABLE[number]
        assert (read.group, read.name) == (mine.group, mine.name if port == 5 else mine.last)
        assert read.ctype.removesuffix("_t") == mine.kind


def test_an_entry_beyond_the_table_is_answered_empty(grounded: Pilot) -> None:
    assert ask(grounded, b"\x5c\x02\xff\xff") == b"\x02"


def test_the_checksum_changes_with_any_name_type_group_or_order() -> None:
    table = [Entry("a", "x", 1), Entry("a", "y", 1), Entry("b", "z", 2)]
    changed = [
        [replace(table[0], name="w"), *table[1:]],
        [replace(table[0], kind=2), *table[1:]],
        [*table[:2], replace(table[2], group="c")],
        [table[1], table[0], table[2]],
        table[:2],
    ]
    sums = {Contents(one).crc for one in (table, *changed)}
    assert len(sums) == 6
    assert Contents(list(table)).crc == Contents(table).crc


def test_flags_of_persistent_and_read_only_parameters_are_those_of_the_firmware() -> None:
    kinds = {one.name: parameters.type_byte(one) for one in TABLE}
    assert kinds["ctrlMel.mass"] == 0x06 | 0x10
    assert kinds["stabilizer.controller"] == 0x08
    assert kinds["firmware.revision0"] == 0x0A | 0x40


def test_a_written_parameter_is_read_back_and_acts(grounded: Pilot) -> None:
    number = struct.pack("<H", param_id("ctrlMel.kp_z"))
    assert ask(grounded, PARAM_WRITE + number + struct.pack("<f", 2.5)) == number + struct.pack("<f", 2.5)
    assert ask(grounded, PARAM_READ + number) == number + b"\0" + struct.pack("<f", 2.5)
    assert grounded.firmware().parameters["ctrlMel.kp_z"] == 2.5
    assert 2.5 in grounded.firmware().parameters.gains()


def test_unknown_read_only_short_and_senseless_writes_change_nothing(grounded: Pilot) -> None:
    vehicle = grounded.fleet.vehicles[0]
    before = grounded.firmware().parameters.changes
    assert ask(grounded, PARAM_WRITE + b"\xff\xff\0") == b"\xff\xff\x02"
    assert ask(grounded, PARAM_READ + b"\xff\xff") == b"\xff\xff\x02"
    read_only = struct.pack("<HI", param_id("firmware.revision0"), 7)
    assert vehicle.handle(PARAM_WRITE + read_only) == []
    number = struct.pack("<H", param_id("ctrlMel.kp_z"))
    assert vehicle.handle(PARAM_WRITE + number + b"\0\0") == []
    assert vehicle.handle(PARAM_WRITE + number + struct.pack("<f", float("nan"))) == []
    assert grounded.firmware().parameters.changes == before
    assert vehicle.refusals.count == 2


@pytest.mark.parametrize(
    ("name", "type_number", "value", "error"),
    [("ctrlMel.mass", 0x06, 0.03, 0), ("no.such", 0x06, 1.0, 2), ("ctrlMel.mass", 0x08, 1, 22),
     ("firmware.modified", 0x08, 1, 13)],
)  # fmt: skip
def test_set_by_name_answers_as_the_firmware_does(
    grounded: Pilot, name: str, type_number: int, value: float, error: int
) -> None:
    wire = grounded.wire()
    Param(wire).set_value_raw(name, type_number, value)
    assert wire.answers[-1][-1] == error
    if not error:
        assert grounded.firmware().parameters[name] == pytest.approx(value)


def test_extended_types_defaults_and_the_eeprom_answer_with_a_status(grounded: Pilot) -> None:
    kept, plain = (struct.pack("<H", param_id(name)) for name in ("ctrlMel.kp_z", "kalman.initialX"))
    two, new = struct.pack("<f", 1.25), struct.pack("<f", 2.5)
    assert ask(grounded, PARAM_MISC + b"\x07" + kept) == b"\x07" + kept + b"\x00\x01"
    assert ask(grounded, PARAM_MISC + b"\x07" + plain) == b"\x07" + plain + b"\x02"
    assert ask(grounded, PARAM_MISC + b"\x08" + kept) == b"\x08" + kept + b"\x00" + two
    assert ask(grounded, PARAM_MISC + b"\x04" + kept) == b"\x04" + kept + b"\x00" + two
    ask(grounded, PARAM_WRITE + kept + new)
    assert ask(grounded, PARAM_MISC + b"\x03" + kept) == b"\x03" + kept + b"\x00"
    assert ask(grounded, PARAM_MISC + b"\x04" + kept) == b"\x04" + kept + b"\x01" + two + new
    grounded.firmware().boot()
    assert ask(grounded, PARAM_READ + kept) == kept + b"\x00" + new  # what was stored outlives a reboot
    assert ask(grounded, PARAM_MISC + b"\x05" + kept) == b"\x05" + kept + b"\x00"
    assert ask(grounded, PARAM_MISC + b"\x05" + kept) == b"\x05" + kept + b"\x02"


def block(pilot: Pilot, number: int, names: list[tuple[str, int]], period: int) -> None:
    """Make and start a block; `names` with the type numbers to fetch them as, the period in 10 ms."""
    operations = b"".join(bytes([kind]) + struct.pack("<H", log_id(name)) for name, kind in names)
    assert ask(pilot, LOG_CONTROL + bytes([6, number]) + operations) == bytes([6, number, 0])
    assert ask(pilot, LOG_CONTROL + bytes([3, number, period])) == bytes([3, number, 0])


def logged(pilot: Pilot, number: int) -> list[tuple[int, bytes]]:
    """Return time [ms] and values of every packet of a block."""
    data = [one.datagram for one in pilot.out if one.datagram[0] == LOG_DATA and one.datagram[1] == number]
    return [(int.from_bytes(one[2:5], "little"), one[5:]) for one in data]


def test_blocks_come_at_their_periods_and_carry_the_state_in_the_types_asked_for(grounded: Pilot) -> None:
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


def test_stopped_and_deleted_blocks_are_silent_and_their_numbers_are_free(grounded: Pilot) -> None:
    block(grounded, 1, [("acc.x", 7)], 1)
    assert ask(grounded, LOG_CONTROL + b"\x04\x01") == b"\x04\x01\x00"
    grounded.fly(0.1)
    assert logged(grounded, 1) == []
    assert ask(grounded, LOG_CONTROL + b"\x02\x01") == b"\x02\x01\x00"
    assert ask(grounded, LOG_CONTROL + b"\x02\x01") == b"\x02\x01\x02"
    block(grounded, 1, [("acc.x", 7)], 1)


def test_blocks_too_many_too_long_twice_or_of_unknown_variables_are_refused(grounded: Pilot) -> None:
    seven = b"".join(b"\x07" + struct.pack("<H", k) for k in range(7))
    assert ask(grounded, LOG_CONTROL + b"\x06\x01" + seven)[-1] == 7  # 28 bytes: E2BIG
    assert ask(grounded, LOG_CONTROL + b"\x06\x01")[-1] == 17  # EEXIST
    assert ask(grounded, LOG_CONTROL + b"\x06\x02\x07\xf0\xff")[-1] == 2  # ENOENT
    ask(grounded, LOG_CONTROL + b"\x05")
    assert [ask(grounded, LOG_CONTROL + bytes([6, k]))[-1] for k in range(17)] == [0] * 16 + [12]
    assert ask(grounded, LOG_CONTROL + b"\x07\x63\x07\0\0")[-1] == 2
    assert ask(grounded, LOG_CONTROL + b"\x63\x00")[-1] == 8


def test_every_variable_can_be_logged(grounded: Pilot) -> None:
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


def test_the_logs_of_a_moving_vehicle_have_the_firmwares_signs(grounded: Pilot) -> None:
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


def test_clients_find_the_lights_card_decks_and_loops_that_they_ask_for() -> None:
    set_there = """led.bitmask ring.effect ring.solidRed ring.headlightEnable ring.fadeColor ring.fadeTime
        usd.logging usd.canLog deck.bcFlow2 deck.bcLighthouse4 deck.bcLedRing velCtlPid.vxKFF velCtlPid.vyKFF
        velCtlPid.vzKFF system.selftestPassed system.testLogParam system.taskDump cpu.flash"""
    logged_there = """controller.roll controller.pitch controller.yaw controller.rollRate controller.pitchRate
        controller.yawRate controller.cmd_thrust controller.actuatorThrust posCtl.targetX posCtl.targetVZ
        posCtl.bodyVX supervisor.accNorm kalman.q0 kalman.q3 sys.testLogParam"""
    kinds = {one.name: parameters.type_byte(one) for one in TABLE}
    assert set(set_there.split()) <= set(kinds)
    assert kinds["ring.effect"] == 0x08 | 0x10  # uint8, persistent
    assert kinds["deck.bcFlow2"] == 0x08 | 0x40  # uint8, read-only
    assert set(logged_there.split()) <= {f"{one.group}.{one.name}" for one in VARIABLES}


def test_decks_of_the_build_are_told_as_attached() -> None:
    output = Pilot(np.zeros((1, 4)), build=Build(decks=("bcFlow2", "bcUSD"))).firmware().parameters
    attached = {one.name for one in TABLE if one.group == "deck" and output[one.name] == 1}
    assert attached == {"deck.bcFlow2", "deck.bcUSD"}
    assert output["usd.canLog"] == 1


def test_a_deck_that_no_firmware_knows_is_refused_with_those_it_knows() -> None:
    with pytest.raises(ValueError, match=r"deck 'flow': known are bcAI, .*bcFlow2"):
        CrtpRoomParams(decks=("flow",))


def test_logs_of_the_cascade_are_what_it_is_asked_for_and_asks_for() -> None:
    pilot = Pilot(np.array([[0.0, 0.0, 1.0, math.pi / 2]]))
    expected = Setpoint(
        x=Mode.ABS, y=Mode.ABS, z=Mode.ABS, yaw=Mode.ABS, pos=(0.3, 0.1, 1.2), attitude_deg=(0.0, 0.0, 90.0)
    )
    pilot.fly(1.0)  # arms
    pilot.fly(0.05, pilot.hold(expected))
    log = {f"{one.group}.{one.name}": one.read(pilot.firmware()) for one in VARIABLES}
    # turned to the left by 90 degrees: the vehicle's ahead is y, its left is -x
    np.testing.assert_allclose([log[f"posCtl.target{axis}"] for axis in "XYZ"], [0.1, -0.3, 1.2], atol=1e-3)
    x, y, z = pilot.pos()
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
    np.testing.assert_allclose([qx, qy, qz, qw], pilot.swarm.state[0, QUAT])
    force = [log[f"acc.{axis}"] for axis in "xyz"]
    assert log["supervisor.accNorm"] == pytest.approx(math.hypot(*force))


def test_feed_forward_of_the_velocity_tilts_by_itself() -> None:
    ahead = Setpoint(
        x=Mode.VELOCITY, y=Mode.VELOCITY, z=Mode.ABS, yaw=Mode.ABS, pos=(0, 0, 1.0), vel=(0.2, 0.0, 0.0)
    )
    pitch = []
    for feed in (0.0, 10.0):
        pilot = Pilot(np.array([[0.0, 0.0, 1.0, 0.0]]))
        pilot.firmware().parameters.set("velCtlPid.vxKFF", feed)
        pilot.fly(1.0)  # arms
        pilot.fly(0.01, pilot.hold(ahead))
        pitch.append(pilot.firmware().rows.memory[ATTITUDE_SETPOINT + 1])
    assert pitch[1] - pitch[0] == pytest.approx(-10.0 * 0.2)


def test_the_trajectory_memory_keeps_what_is_written_within_it(grounded: Pilot) -> None:
    memory = grounded.fleet.vehicles[0]
    assert ask(grounded, b"\x4c\x01") == b"\x01\x01"
    assert ask(grounded, b"\x4c\x02\x00")[2:7] == b"\x12" + struct.pack("<I", 4096)
    assert ask(grounded, b"\x4c\x02\x05") == b"\x02\x05"
    place = b"\x00" + struct.pack("<I", 100)
    assert ask(grounded, b"\x4e" + place + b"hello") == place + b"\0"
    assert ask(grounded, b"\x4d" + place + b"\x05") == place + b"\0hello"
    outside = b"\x00" + struct.pack("<I", 4095)
    assert ask(grounded, b"\x4e" + outside + b"hello") == outside + b"\x05"
    assert ask(grounded, b"\x4d" + outside + b"\x05") == outside + b"\x05"
    assert len(memory.firmware.uploads.memory) == 4096
