"""Micro-SD logs of both formats come back as they were written; damage costs only its own rows."""

import struct
from zlib import crc32

import numpy as np
import pytest

from q2q_model.flights.tables.column_map import SourceColumn
from q2q_model.flights.tables.usd_flight import clock_note, columns_of_logs
from q2q_model.flights.tables.usd_log import UsdLogError, is_usd_log, usd_log
from q2q_model.geometry.quaternion32 import compress_quat
from q2q_model.geometry.rotations import normalised, quat_from_euler
from q2q_model.signals.values import Array

ROWS, IN_BLOCK = 230, 20
NAMES = (
    "stateEstimate.x(f)",
    "stateEstimate.y(f)",
    "stateEstimate.z(f)",
    "pm.vbatMV(H)",
    "stateEstimateZ.quat(I)",
)
KIND = "<fffHI"


def values(seed: int) -> list[tuple[float, float, float, int, int]]:
    rng = np.random.default_rng(seed)
    rows = []
    for k in range(ROWS):
        x, y, z = (float(np.float32(one)) for one in (0.01 * k, *rng.normal(size=2)))
        quat = normalised(rng.normal(size=4))
        rows.append((x, y, z, 3700 + k, compress_quat((quat[0], quat[1], quat[2], quat[3]))))
    return rows


def with_crc(data: bytes) -> bytes:
    return data + struct.pack("<I", crc32(data))


def with_inverted_crc(data: bytes) -> bytes:
    return data + struct.pack("<I", crc32(data) ^ 0xFFFFFFFF)


def old_format(seed: int = 0, first_us: int = 9_000) -> bytes:
    """Return a log of the first format: 100 Hz, in blocks; its CRC is stored inverted."""
    header = bytes([len(NAMES) + 1]) + b"".join(f"{one},".encode() for one in ("tick(I)", *NAMES))
    rows = [
        struct.pack("<I", (first_us + 10_000 * k) % 2**32) + struct.pack(KIND, *row)
        for k, row in enumerate(values(seed))
    ]
    blocks = [rows[at : at + IN_BLOCK] for at in range(0, ROWS, IN_BLOCK)]
    return with_inverted_crc(header) + b"".join(
        with_inverted_crc(bytes([len(block)]) + b"".join(block)) for block in blocks
    )


def new_format(version: int, seed: int = 0, first_s: float = 12.0, between: int = 0) -> bytes:
    """Return a log of version 1 or 2; of another event type, one comes each 10 rows, or several each row."""
    header = struct.pack("<BHHH", 0xBC, version, 2, 7) + b"fixedFrequency\0" + struct.pack("<H", len(NAMES))
    header += b"".join(one.encode() + b"\0" for one in NAMES)
    header += struct.pack("<H", 9) + b"estimator\0" + struct.pack("<H", 1) + b"source(B)\0"
    stamp, unit = ("<HI", 1e-3) if version == 1 else ("<HQ", 1e-6)
    events = []
    for k, row in enumerate(values(seed)):
        at = round((first_s + 0.01 * k) / unit)
        events.append(struct.pack(stamp, 7, at) + struct.pack(KIND, *row))
        events += [struct.pack(stamp, 9, at) + b"\3"] * (between or k % 10 == 0)
    return with_crc(header + b"".join(events))


LOGS = pytest.mark.parametrize("data", [old_format(), new_format(1), new_format(2)], ids=["old", "v1", "v2"])


@LOGS
def test_every_value_comes_back(data: bytes) -> None:
    log = usd_log(data)
    assert is_usd_log(data)
    assert log.repairs == ()
    assert log.unread == (() if data == old_format() else ("estimator (23 rows)",))
    np.testing.assert_allclose(np.diff(log.t), 0.01, atol=1e-9)
    for k, name in enumerate(NAMES):
        np.testing.assert_array_equal(log.variables[name[:-3]], [row[k] for row in values(0)])


@LOGS
def test_a_log_that_was_cut_off_gives_the_rows_before_the_cut_and_says_so(data: bytes) -> None:
    log = usd_log(data[:-200])
    assert log.repairs
    assert ROWS - 2 * IN_BLOCK <= len(log.t) < ROWS
    np.testing.assert_array_equal(
        log.variables["stateEstimate.x"], [row[0] for row in values(0)][: len(log.t)]
    )


@pytest.mark.parametrize("row", [0, 1, 115, ROWS - 2, ROWS - 1])
@pytest.mark.parametrize("byte", [3, 5, 7])
def test_a_damaged_stamp_costs_its_own_row(row: int, byte: int) -> None:
    data, plain = bytearray(new_format(2)), usd_log(new_format(2))
    stamp = struct.pack("<HQ", 7, round(1e6 * plain.t[row]))
    data[data.index(stamp) + 2 + byte] ^= 0x40  # by 18 min, 13 days, 146000 years
    log = usd_log(bytes(data))
    np.testing.assert_array_equal(log.t, np.delete(plain.t, row))
    np.testing.assert_array_equal(
        log.variables["stateEstimate.x"], np.delete(plain.variables["stateEstimate.x"], row)
    )
    assert log.repairs[-1] == "1 row whose time does not increase or is damaged"


def test_a_log_whose_clock_wraps_is_whole() -> None:
    plain, wrapped = usd_log(old_format(first_us=0)), usd_log(old_format(first_us=2**32 - 1_000_000))
    assert wrapped.repairs == ()
    np.testing.assert_allclose(wrapped.t - wrapped.t[0], plain.t, atol=1e-9)
    assert wrapped.t[0] == pytest.approx(4293.967296)


def test_the_event_type_with_positions_is_read_though_another_is_faster() -> None:
    slow, fast = usd_log(new_format(2)), usd_log(new_format(2, between=3))
    np.testing.assert_array_equal(fast.t, slow.t)
    assert fast.unread == ("estimator (690 rows)",)
    of_source = {axis: (SourceColumn("source"),) for axis in "xyz"}
    assert set(usd_log(new_format(2), of_source).variables) == {"source"}


def test_a_spoiled_block_costs_its_own_rows() -> None:
    data = bytearray(old_format())
    data[-5] ^= 0xFF
    log = usd_log(bytes(data))
    assert log.repairs == (f"{ROWS % IN_BLOCK} rows of a block with a wrong CRC",)
    assert len(log.t) == ROWS - ROWS % IN_BLOCK


@pytest.mark.parametrize(
    "data", [b"", b"t,x\n0,1\n", old_format()[:50], new_format(2)[:40], b"\xbc\x09\0\1\0abc"]
)
def test_what_is_no_log_is_refused(data: bytes) -> None:
    with pytest.raises(UsdLogError):
        usd_log(data)


def flight(*data: bytes, **given: tuple[SourceColumn, ...]) -> dict[str, Array]:
    return columns_of_logs({f"cf{k}": usd_log(one) for k, one in enumerate(data, 1)}, given)


@pytest.mark.parametrize("first_s", [0.209, 0.709, 1.209])
def test_clocks_from_the_start_of_logging_stay_as_they_are_where_first_rows_are_lost(first_s: float) -> None:
    logs = old_format(), old_format(seed=1, first_us=round(1e6 * first_s))
    together = flight(*logs)
    assert together["t"][0] == pytest.approx(first_s + 0.001)  # the first row that both have
    np.testing.assert_allclose(together["cf1_x"] - together["cf2_x"], first_s - 0.009, atol=1e-6)
    told = f"clocks count from the start of logging: taken as common (cf1 0.009 s, cf2 {first_s:.3f} s)"
    note, _, doubt = clock_note({f"cf{k}": usd_log(one) for k, one in enumerate(logs, 1)}).partition("; ")
    assert note == told
    assert ("enable-on-startup" in doubt) == (first_s > 0.5)


def test_clocks_from_the_start_of_logging_stay_as_they_are_where_all_logs_lost_their_first_rows() -> None:
    lost = flight(old_format(first_us=609_000), old_format(seed=1, first_us=1_209_000))
    assert lost["t"][0] == pytest.approx(1.21)
    np.testing.assert_allclose(lost["cf1_x"] - lost["cf2_x"], 0.6, atol=1e-6)


@pytest.mark.parametrize("first_s", [12.03, 12.6, 400.0])
def test_vehicles_switched_on_at_their_own_times_begin_together(first_s: float) -> None:
    apart = flight(new_format(2), new_format(2, seed=1, first_s=first_s))
    np.testing.assert_allclose(apart["cf1_x"], apart["cf2_x"], atol=1e-6)
    assert apart["t"][0] == 0.0


def test_a_log_from_the_start_of_logging_begins_with_one_from_its_switching_on() -> None:
    mixed = flight(old_format(), new_format(2, seed=1))
    np.testing.assert_allclose(mixed["cf1_x"], mixed["cf2_x"], atol=1e-6)


def test_units_are_si_and_attitudes_are_unpacked_to_ten_bits() -> None:
    found = flight(new_format(2))
    np.testing.assert_allclose(found["cf1_vbat"], [1e-3 * row[3] for row in values(0)], atol=1e-9)
    quat = np.stack([found[f"cf1_q{axis}"] for axis in "xyzw"], axis=-1)
    rng = np.random.default_rng(0)
    for row in quat:
        rng.normal(size=2)
        # 1 - |q p| is half the squared error: three parts err by 0.0007, the largest by their sum at most
        assert abs(row @ normalised(rng.normal(size=4))) > 1.0 - (3 + 9) * 0.0007**2 / 2


def test_angles_of_the_firmware_become_an_attitude_with_its_pitch_turned() -> None:
    log = usd_log(new_format(2))
    angles = {
        f"stateEstimate.{one}": np.full(ROWS, angle)
        for one, angle in (("roll", 10.0), ("pitch", 20.0), ("yaw", 30.0))
    }
    kept = {name: one for name, one in log.variables.items() if name != "stateEstimateZ.quat"}
    found = columns_of_logs({"cf1": type(log)(log.t, kept | angles, ())})
    quat = [found[f"cf1_q{axis}"][0] for axis in "xyzw"]
    np.testing.assert_allclose(quat, quat_from_euler(*np.deg2rad([10.0, -20.0, 30.0])), atol=1e-12)


def test_a_hole_of_a_log_is_marked() -> None:
    log = usd_log(new_format(2))
    kept = np.r_[0:100, 110:ROWS]
    found = columns_of_logs(
        {"cf1": type(log)(log.t[kept], {n: v[kept] for n, v in log.variables.items()}, ())}
    )
    assert 9 <= found["cf1_gap"].sum() <= 11


def test_a_flight_without_an_end_is_refused() -> None:
    log = usd_log(new_format(2))
    late = log.t + np.where(np.arange(ROWS) < 100, 0.0, 1e12)
    with pytest.raises(ValueError, match=r"the logs span 10+2 s \(maximum 14400 s\)"):
        columns_of_logs({"cf1": type(log)(late, log.variables, ())})


def test_a_map_comes_before_the_firmwares_names_and_lacking_positions_are_named() -> None:
    found = flight(new_format(2), z=(SourceColumn("stateEstimate.x", 2.0, 1.0),))
    np.testing.assert_allclose(found["cf1_z"], 2.0 * found["cf1_x"] + 1.0, atol=1e-9)
    with pytest.raises(ValueError, match=r"z of the column map: no column stateEstimate.zz; did you mean"):
        flight(new_format(2), z=(SourceColumn("stateEstimate.zz"),))
    log = usd_log(new_format(2))
    kept = {name: one for name, one in log.variables.items() if name != "stateEstimate.z"}
    with pytest.raises(ValueError, match=r"cf1 logs no z; .* it logs stateEstimate.x"):
        columns_of_logs({"cf1": type(log)(log.t, kept, ())})
