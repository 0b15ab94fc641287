"""Identify real flights as a user does: table, bag, record, gains. Skipped where the data are absent."""

import os
from pathlib import Path

import pytest

from q2q_model.identification.command_gains import gains_from_commands
from q2q_model.identification.procedure import recorded_altitudes
from q2q_model.tools.recordings import read_recordings
from q2q_model.vehicle import CRAZYFLIE_2_0
from q2q_sim.commands import bag_import

DATA = Path(os.environ.get("Q2Q_DATA", Path(__file__).parents[2] / "shared" / "data")) / "neural_swarm"
FLIGHTS = ("dc21_swap_ss_00", "dc21_swap_ss_02", "dc21_swap_ss_04", "dc21_swap_sss_02")


@pytest.mark.skipif(not DATA.is_dir(), reason=f"real flights are not at {DATA}: set Q2Q_DATA")
def test_gains_from_thrust_commands_are_those_that_flew(tmp_path: Path) -> None:
    """The controller of these flights had K_p,z = 10 and K_d,z = 5 by its authors' word (Neural-Swarm2)."""
    for name in FLIGHTS:
        assert bag_import.main([str(DATA / f"{name}.parquet"), "--out", str(tmp_path / name)]) == 0
    recordings, _ = read_recordings([tmp_path / name for name in FLIGHTS])
    found = gains_from_commands([recorded_altitudes(one, CRAZYFLIE_2_0) for one in recordings])
    assert found.k_p.value == pytest.approx(10.0, rel=0.1)  # issue 3 asks for 10 %
    assert found.k_d.value == pytest.approx(5.0, rel=0.1)
    assert found.needs_offset  # each flight's constant, which a PD law without offset takes for draft
