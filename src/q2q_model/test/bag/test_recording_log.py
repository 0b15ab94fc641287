"""The log of a recording is joined to its flight by vehicle and stamp."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from q2q_model.bag import LOG_TOPIC, BagError, BagWriter, write_log_row
from q2q_model.bag.log_topic import LOG_TYPE
from q2q_model.flights.flight_log import FlightLog
from q2q_model.identification.push.log_mass import LOG_MASS
from q2q_model.identification.push.recorded_push import motion_of, push_of_log
from q2q_model.recordings.recording_reader import recording_of_bag
from q2q_model.signals.values import MocapFrame

T = 1.7e9 + 0.01 * np.arange(200)
COLUMNS = ("faz_est", "gap", "pwm1", "pwm2", "pwm3", "pwm4")
PUSH = np.stack([np.arange(200.0), -np.arange(200.0)], axis=1)
"""Of cf1 and cf2 at every tick [m/s^2]: shows vehicle and row."""


def _log() -> FlightLog:
    values = np.zeros((T.size, 2, len(COLUMNS)))
    values[..., 0] = LOG_MASS * PUSH
    return FlightLog(T, ("cf1", "cf2"), COLUMNS, ("",) * len(COLUMNS), values)


def _bag(path: Path, *logs: FlightLog) -> Path:
    level = np.tile([0.0, 0.0, 0.0, 1.0], (2, 1))
    with BagWriter(path) as bag:
        for t in T:
            frame = MocapFrame(float(t), ("cf1", "cf2"), np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 1.0]]), level)
            bag.write_signal("/mocap", round(t * 1e9), frame)
        bag.add_topic(LOG_TOPIC, LOG_TYPE)
        for log in logs:
            for row in range(log.t.size):
                write_log_row(bag, log, row)
    return path


def test_a_log_belongs_to_its_vehicles_and_ticks_in_any_order_and_rate(tmp_path: Path):
    log = _log()
    every = np.arange(T.size)
    cases = {
        "same": (log, every),
        "reversed": (replace(log, names=log.names[::-1], values=log.values[:, ::-1]), every),
        "half": (replace(log, t=T[::2], values=log.values[::2]), every[::2]),
        "late": (replace(log, t=T[50:], values=log.values[50:]), every[50:]),
        "longer": (replace(log, t=np.append(T, T[-1] + 1.0), values=log.values[[*every, 0]]), every),
    }
    for name, (given, rows) in cases.items():
        recording = recording_of_bag(_bag(tmp_path / name, given))
        assert recording.log is not None
        found = push_of_log(name, recording.log, motion_of(recording.flight), LOG_MASS)
        np.testing.assert_allclose(found.push[rows], PUSH[rows], rtol=1e-12, err_msg=name)
        assert found.measured[rows].all()
        assert found.measured.sum() == 2 * rows.size


def test_rows_without_a_force_are_a_gap_of_their_vehicle_alone(tmp_path: Path):
    log = _log()
    values = log.values.copy()
    values[7, 0, COLUMNS.index("faz_est")] = np.nan
    recording = recording_of_bag(_bag(tmp_path / "flight", replace(log, values=values)))
    assert recording.log is not None
    found = push_of_log("flight", recording.log, motion_of(recording.flight), LOG_MASS)
    assert np.argwhere(~found.measured).tolist() == [[7, 0]]
    assert np.isfinite(found.push).all()


def test_a_log_of_other_vehicles_or_another_clock_is_refused(tmp_path: Path):
    other = replace(_log(), names=("cf1", "cf3"))
    with pytest.raises(BagError, match="other: its log has vehicles cf1, cf3, not cf1, cf2:"):
        recording_of_bag(_bag(tmp_path / "other", other))
    booted = replace(_log(), t=T - T[0] + 7.0)
    with pytest.raises(BagError, match=r"none of the 200 rows of its log \(7\.000 to 8\.990 s\) .*200 ticks"):
        recording_of_bag(_bag(tmp_path / "booted", booted))


def test_a_log_whose_columns_change_is_refused_and_one_without_a_row_is_none(tmp_path: Path) -> None:
    assert recording_of_bag(_bag(tmp_path / "silent")).log is None
    first, second = (
        replace(_log(), t=T[half], values=_log().values[half]) for half in (slice(100), slice(100, 200))
    )
    renamed = replace(second, columns=("vbat", *COLUMNS[1:]))
    with pytest.raises(BagError, match="columns of /log change during the flight; split the bag there"):
        recording_of_bag(_bag(tmp_path / "changed", first, renamed))
