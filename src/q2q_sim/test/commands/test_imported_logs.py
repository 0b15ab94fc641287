"""Micro-SD logs go into one bag, on one clock."""

from pathlib import Path

import numpy as np
import pytest
from line_log import log_of_a_line

from q2q_model.bag import read_flight
from q2q_sim.commands.bag_import import main


def test_a_log_goes_into_a_bag_under_its_files_name(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ("cf7_03", "cf8_03"):
        (tmp_path / name).write_bytes(log_of_a_line())
    logs = [str(tmp_path / name) for name in ("cf7_03", "cf8_03")]
    assert main([*logs, "--out", str(tmp_path / "bag")]) == 0
    assert "  clocks count from the start of logging: taken as common" in capsys.readouterr().out
    flight = read_flight(tmp_path / "bag")
    assert flight.names == ("cf7", "cf8")
    np.testing.assert_allclose(flight.mocap_pos[:, 1, 0], flight.t, atol=1e-6)
    assert main([*logs, "--names", "cf7,cf7", "--out", str(tmp_path / "other")]) == 1
    assert "give --names, a different one each" in capsys.readouterr().err


def test_vehicles_switched_on_at_their_own_times_begin_together(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for name, first_us in (("cf7_03", 35_200_000), ("cf8_03", 35_800_000)):
        (tmp_path / name).write_bytes(log_of_a_line(first_us))
    logs = [str(tmp_path / name) for name in ("cf7_03", "cf8_03")]
    assert main([*logs, "--out", str(tmp_path / "bag")]) == 0
    told = "clocks count from switching on: all first rows are taken as one time (cf7 35.200 s, cf8 35.800 s)"
    assert told in capsys.readouterr().out
    flight = read_flight(tmp_path / "bag")
    np.testing.assert_allclose(flight.mocap_pos[:, 0], flight.mocap_pos[:, 1], atol=1e-6)
