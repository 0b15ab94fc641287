"""The air `recorded` plays back what real flights leave of the room's wake, or is refused before a flight."""

import os
from pathlib import Path

import numpy as np
import pytest

from q2q_model.signals.values import Array
from q2q_sim.air.air_file import load
from q2q_sim.air.air_names import AirError, air_path, check_air
from q2q_sim.air.learning.jet.jet_table import push_in_table
from q2q_sim.air.learning.recorded_air import FADE
from q2q_sim.air.lookup.find_air import find_air
from q2q_sim.air.room_air import RoomAir

DATA = Path(os.environ.get("Q2Q_DATA", Path(__file__).parents[5] / "shared" / "data"))
ROOM = load(air_path("room"))
MASS = 0.032
"""Of the logs' force [kg]."""
GAP = 0.5
"""Of the vehicles above each other [m]."""
APART, UNDER = 500, 600
"""Rows beside each other, and above each other."""


def write_flight(path: Path, n: Array) -> None:
    """Write a flight whose lower vehicle feels the room's jet and its residual process with values n."""
    rows = APART + UNDER
    lower_x = np.where(np.arange(rows) < APART, 1.0, 0.0)
    columns = {"t": 0.01 * np.arange(1, rows + 1)}
    for name, x, z in (("cf1", lower_x, 0.6), ("cf2", np.zeros(rows), 0.6 + GAP)):
        at_rest = (
            "y",
            "vx",
            "vy",
            "vz",
            "ax",
            "ay",
            "az",
            "qx",
            "qy",
            "qz",
            "wp",
            "wq",
            "wr",
            "gap",
            "faz_est",
        )
        columns |= {f"{name}_{key}": np.zeros(rows) for key in at_rest}
        columns |= {f"{name}_x": x, f"{name}_z": np.full(rows, z), f"{name}_qw": np.ones(rows)}
        columns |= {f"{name}_{key}": np.full(rows, 0.33) for key in ("thrust_cmd", "thrust_est")}
        columns |= {f"{name}_pwm{k}": np.full(rows, 0.65) for k in range(1, 5)}
    assert ROOM.jet is not None
    assert ROOM.residual is not None
    eta = float(push_in_table(ROOM.jet, np.array([GAP]), np.zeros(1))[0])
    size = ROOM.residual.floor_mps2 + ROOM.residual.slope * eta
    columns["cf1_faz_est"][APART:] = MASS * (size * n - eta)
    table = np.stack(list(columns.values()), axis=1)
    np.savetxt(path, table, delimiter=",", header=",".join(columns), comments="", fmt="%.17g")


def recording_of(air: object) -> Array:
    """Return the recording of an air."""
    assert isinstance(air, RoomAir)
    assert air.residual is not None
    assert air.residual.recording is not None
    return air.residual.recording


def test_what_a_flight_leaves_of_the_wake_is_played_back(tmp_path: Path) -> None:
    n = np.cumsum(np.random.default_rng(3).standard_normal(UNDER))
    write_flight(tmp_path / "pair.csv", n)
    found = find_air(f"recorded:{tmp_path / 'pair.csv'}")
    played = recording_of(found)
    assert UNDER - 2 <= len(played) <= UNDER
    seen = n[: len(played)]
    np.testing.assert_allclose(played, (seen - seen.mean()) / seen.std(), atol=1e-6)
    assert isinstance(found, RoomAir)
    assert found.jet is not None


def test_a_hole_in_the_rows_is_not_played_back(tmp_path: Path) -> None:
    n = np.cumsum(np.random.default_rng(3).standard_normal(UNDER))
    write_flight(tmp_path / "pair.csv", n)
    table = (tmp_path / "pair.csv").read_text().splitlines()
    (tmp_path / "hole.csv").write_text("\n".join(table[:801] + table[901:]) + "\n")
    played = recording_of(find_air(f"recorded:{tmp_path / 'hole.csv'}"))
    assert UNDER - 100 - FADE - 4 <= len(played) <= UNDER - 100 - FADE
    assert np.abs(np.diff(played, 2)).min() > 1e-9  # nowhere straight, as a bridge over the hole is


def test_tables_of_flights_in_a_folder_are_played_back(tmp_path: Path) -> None:
    n = np.cumsum(np.random.default_rng(3).standard_normal(UNDER))
    write_flight(tmp_path / "pair.csv", n)
    (tmp_path / "manifest.csv").write_text("name,seconds\npair,11\n")
    alone, folder = (recording_of(find_air(f"recorded:{path}")) for path in (tmp_path / "pair.csv", tmp_path))
    np.testing.assert_array_equal(folder, alone)


def test_a_flight_without_a_pair_is_refused(tmp_path: Path) -> None:
    write_flight(tmp_path / "pair.csv", np.zeros(UNDER))
    table = (tmp_path / "pair.csv").read_text().splitlines()
    (tmp_path / "apart.csv").write_text("\n".join(table[: 1 + APART]) + "\n")
    with pytest.raises(
        AirError, match=r"apart.csv: 0 samples .* under another vehicle; must be at least 300"
    ):
        find_air(f"recorded:{tmp_path / 'apart.csv'}")


def test_missing_flights_are_named_before_anything_is_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("Q2Q_DATA", str(tmp_path))
    with pytest.raises(AirError, match=r"no recorded flights in .*: get the flights of docs/real_flights.md"):
        check_air("recorded")
    with pytest.raises(AirError, match="give a bag, a table or a folder of them"):
        check_air("recorded:nowhere/flights")
    (tmp_path / "neural_swarm").mkdir()
    with pytest.raises(AirError, match="no dc21_randomwalk_s_00, dc21_randomwalk_ss_00"):
        find_air("recorded")
    (tmp_path / "empty.csv").write_text("a,b\n1,2\n")
    with pytest.raises(AirError, match=r"empty.csv: the table has no column t"):
        find_air(f"recorded:{tmp_path / 'empty.csv'}")


@pytest.mark.skipif(not DATA.is_dir(), reason=f"real flights are not at {DATA}: set Q2Q_DATA")
def test_real_flights_give_a_long_recording_that_is_correlated_as_the_fitted_process() -> None:
    n = recording_of(find_air(f"recorded:{DATA / 'neural_swarm' / 'dc19_randomwalk_ss_04.parquet'}"))
    assert len(n) > 1500  # 2436 rows lie under another vehicle
    assert abs(float(n.mean())) < 1e-9
    assert float(n.std()) == pytest.approx(1.0)
    assert 0.3 < float(np.mean(n[8:] * n[:-8])) < 0.7  # at the fitted correlation time, 0.08 s: 1 / e
