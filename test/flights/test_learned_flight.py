"""Fly Table 6 with the downwash that `identify` learned from recorded flights: model and plant differ."""

from pathlib import Path

import numpy as np

from q2q_model.commands import identify
from q2q_model.model_files.model_file import load
from q2q_sim.loop.closed_loop import FlightOptions, fly
from q2q_sim.scenarios import library

BAGS = Path(__file__).parents[2] / "bags"


def test_the_lower_vehicle_keeps_its_height_with_a_learned_model(tmp_path: Path) -> None:
    bags = [str(BAGS / f"table2_{number}") for number in (1, 2, 5)]
    out = tmp_path / "learned.q2q"
    assert identify.main([*bags, "--out", str(out), "--model-type", "jet", "--no-plots"]) == 0
    flown = fly(library.load("table6"), FlightOptions(mode="aware", model=load(out).interaction))
    missed = flown.true_pos[..., 2] - flown.ref_pos[..., 2]
    assert np.sqrt(np.mean(missed[:, 0] ** 2)) <= 0.035  # issue 3, with the thrust limit; 0.023 with all six
