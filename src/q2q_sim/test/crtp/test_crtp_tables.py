"""Tables, parameters and memory, as cflib reads and writes them."""

import struct
from dataclasses import replace

import numpy as np
import pytest

from cflib_fleet import CflibFleet
from q2q_sim.crtp.fleet_room import CrtpRoomParams
from q2q_sim.crtp.tables import log_toc, param_toc
from q2q_sim.crtp.tables.log_toc import VARIABLES
from q2q_sim.crtp.tables.toc import Toc, TocEntry
from q2q_sim.firmware.firmware_build import Build
from q2q_sim.firmware.parameters.parameter_table import GAINS, TABLE

pytest.importorskip("cflib", reason="cflib is not installed: requirements/dev.txt has it")
from cflib.crazyflie.log import LogTocElement
from cflib.crazyflie.param import Param, ParamTocElement
from crtp_asked import ask

PARAM_READ, PARAM_WRITE, PARAM_MISC = b"\x2d", b"\x2e", b"\x2f"


def param_id(name: str) -> int:
    return next(k for k, one in enumerate(TABLE) if one.name == name)


@pytest.mark.parametrize(
    ("port", "element", "count"), [(5, LogTocElement, len(VARIABLES)), (2, ParamTocElement, len(TABLE))]
)
def test_every_entry_of_a_table_is_what_cflib_reads(
    grounded: CflibFleet, port: int, element: type, count: int
) -> None:
    info = ask(grounded, bytes([port << 4 | 0x0C, 3]))
    output, crc = struct.unpack("<HI", info[1:7])
    assert output == count
    assert crc == (log_toc.LOG_TOC if port == 5 else param_toc.PARAM_TOC).crc
    for number in range(count):
        item = ask(grounded, bytes([port << 4 | 0x0C, 2]) + struct.pack("<H", number))
        assert struct.unpack("<H", item[1:3])[0] == number
        read = element(number, bytearray(item[3:]))
        mine = VARIABLES[number] if port == 5 else TABLE[number]
        assert (read.group, read.name) == (mine.group, mine.name if port == 5 else mine.last)
        assert read.ctype.removesuffix("_t") == mine.kind


def test_an_entry_beyond_the_table_is_answered_empty(grounded: CflibFleet) -> None:
    assert ask(grounded, b"\x5c\x02\xff\xff") == b"\x02"


def test_the_checksum_changes_with_any_name_type_group_or_order() -> None:
    table = [TocEntry("a", "x", 1), TocEntry("a", "y", 1), TocEntry("b", "z", 2)]
    changed = [
        [replace(table[0], name="w"), *table[1:]],
        [replace(table[0], kind=2), *table[1:]],
        [*table[:2], replace(table[2], group="c")],
        [table[1], table[0], table[2]],
        table[:2],
    ]
    sums = {Toc(one).crc for one in (table, *changed)}
    assert len(sums) == 6
    assert Toc(list(table)).crc == Toc(table).crc


def test_flags_of_persistent_and_read_only_parameters_are_those_of_the_firmware() -> None:
    kinds = {one.name: param_toc.type_byte(one) for one in TABLE}
    assert kinds["ctrlMel.mass"] == 0x06 | 0x10
    assert kinds["stabilizer.controller"] == 0x08
    assert kinds["firmware.revision0"] == 0x0A | 0x40


def test_a_written_parameter_is_read_back_and_acts(grounded: CflibFleet) -> None:
    number = struct.pack("<H", param_id("ctrlMel.kp_z"))
    assert ask(grounded, PARAM_WRITE + number + struct.pack("<f", 2.5)) == number + struct.pack("<f", 2.5)
    assert ask(grounded, PARAM_READ + number) == number + b"\0" + struct.pack("<f", 2.5)
    assert grounded.firmware().parameters["ctrlMel.kp_z"] == 2.5
    assert 2.5 in grounded.firmware().parameters.gains()


def test_unknown_read_only_short_and_senseless_writes_change_nothing(grounded: CflibFleet) -> None:
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
    grounded: CflibFleet, name: str, type_number: int, value: float, error: int
) -> None:
    wire = grounded.wire()
    Param(wire).set_value_raw(name, type_number, value)
    assert wire.answers[-1][-1] == error
    if not error:
        assert grounded.firmware().parameters[name] == pytest.approx(value)


def test_extended_types_defaults_and_the_eeprom_answer_with_a_status(grounded: CflibFleet) -> None:
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


def test_after_a_reboot_the_controllers_fly_the_gains_that_a_client_reads(grounded: CflibFleet) -> None:
    def roll_gains() -> tuple[float, float]:
        grounded.fly(0.01)
        (read,) = struct.unpack("<f", ask(grounded, PARAM_READ + gain)[3:])
        return read, float(grounded.fleet._rows.gains[0, GAINS.index("pid_attitude.roll_kp")])

    gain, kept = (struct.pack("<H", param_id(name)) for name in ("pid_attitude.roll_kp", "ring.effect"))
    stock = roll_gains()
    ask(grounded, PARAM_WRITE + gain + struct.pack("<f", 12.0))
    assert roll_gains() == (12.0, 12.0)
    ask(grounded, PARAM_MISC + b"\x03" + kept)  # a boot writes what is stored: as many writes as before it
    grounded.fleet.vehicles[0].handle(b"\xff\xfe\xf0")
    assert roll_gains() == stock == (6.0, 6.0)


def test_clients_find_the_lights_card_decks_and_loops_that_they_ask_for() -> None:
    set_there = """led.bitmask ring.effect ring.solidRed ring.headlightEnable ring.fadeColor ring.fadeTime
        usd.logging usd.canLog deck.bcFlow2 deck.bcLighthouse4 deck.bcLedRing velCtlPid.vxKFF velCtlPid.vyKFF
        velCtlPid.vzKFF system.selftestPassed system.testLogParam system.taskDump cpu.flash"""
    logged_there = """controller.roll controller.pitch controller.yaw controller.rollRate controller.pitchRate
        controller.yawRate controller.cmd_thrust controller.actuatorThrust posCtl.targetX posCtl.targetVZ
        posCtl.bodyVX supervisor.accNorm kalman.q0 kalman.q3 sys.testLogParam"""
    kinds = {one.name: param_toc.type_byte(one) for one in TABLE}
    assert set(set_there.split()) <= set(kinds)
    assert kinds["ring.effect"] == 0x08 | 0x10  # uint8, persistent
    assert kinds["deck.bcFlow2"] == 0x08 | 0x40  # uint8, read-only
    assert set(logged_there.split()) <= {f"{one.group}.{one.name}" for one in VARIABLES}


def test_decks_of_the_build_are_reported_as_attached() -> None:
    output = CflibFleet(np.zeros((1, 4)), build=Build(decks=("bcFlow2", "bcUSD"))).firmware().parameters
    attached = {one.name for one in TABLE if one.group == "deck" and output[one.name] == 1}
    assert attached == {"deck.bcFlow2", "deck.bcUSD"}
    assert output["usd.canLog"] == 1


def test_a_deck_that_no_firmware_knows_is_refused_with_those_it_knows() -> None:
    with pytest.raises(ValueError, match=r"unknown deck 'flow'; choose one of bcAI, .*bcFlow2"):
        CrtpRoomParams(decks=("flow",))


def test_the_trajectory_memory_keeps_what_is_written_within_it(grounded: CflibFleet) -> None:
    memory = grounded.fleet.vehicles[0]
    assert ask(grounded, b"\x4c\x01") == b"\x01\x02"
    assert ask(grounded, b"\x4c\x02\x01")[2:7] == b"\x00" + struct.pack("<I", 0x1FFF)
    assert ask(grounded, b"\x4c\x02\x00")[2:7] == b"\x12" + struct.pack("<I", 4096)
    assert ask(grounded, b"\x4c\x02\x05") == b"\x02\x05"
    place = b"\x00" + struct.pack("<I", 100)
    assert ask(grounded, b"\x4e" + place + b"hello") == place + b"\0"
    assert ask(grounded, b"\x4d" + place + b"\x05") == place + b"\0hello"
    outside = b"\x00" + struct.pack("<I", 4095)
    assert ask(grounded, b"\x4e" + outside + b"hello") == outside + b"\x05"
    assert ask(grounded, b"\x4d" + outside + b"\x05") == outside + b"\x05"
    assert len(memory.firmware.uploads.memory) == 4096
    nowhere = b"\x02" + struct.pack("<I", 0)
    assert ask(grounded, b"\x4e" + nowhere + b"hello") == nowhere + b"\x05"
    assert ask(grounded, b"\x4d" + nowhere + b"\x05") == nowhere + b"\x05"
