"""References of other software: each holds until the next; those of another clock are refused."""

from pathlib import Path

import numpy as np
import pytest
from foreign_bags import write_sqlite
from moving_poses import flown

from q2q_model.bag import (
    BagError,
    TopicMap,
    read_mapped_flight,
)


def test_a_reference_holds_until_the_next_and_a_pause_is_reported() -> None:
    ticks = 5.0 + np.arange(900) / 100.0
    flight, remarks = flown(ticks, np.array([3.0, 7.0, 11.5]))
    assert flight.ref_pos[:, 0, 0].tolist() == [3.0] * 200 + [7.0] * 450 + [11.5] * 250
    assert remarks == ["references of cf1 pause for 4.5 s after t = 7.000 s: held"]


@pytest.mark.parametrize("clock", [-5.0, 12.0])
def test_references_of_another_clock_are_refused(clock: float) -> None:
    ticks = 5.0 + np.arange(500) / 100.0
    spans = f"lie at {clock:.3f} to {clock + 5.0:.3f} s, not 5.000 to 9.990 s: the clocks differ"
    with pytest.raises(ValueError, match=f"references of cf1 {spans}"):
        flown(ticks, clock + np.arange(6.0))


def test_a_mapped_flight_with_references_of_another_clock_is_refused(tmp_path: Path) -> None:
    write_sqlite(tmp_path / "far", offset_ns=700_000_000)
    with pytest.raises(BagError, match=r"far: references of cf1 lie at 0\.700 to 0\.890 s.*clocks differ"):
        read_mapped_flight(tmp_path / "far", TopicMap(vehicles={"cf1": "/a"}, references={"cf1": "/b"}))
