"""A value at the bound of its search has no interval: the optimum may lie beyond it."""

from dataclasses import replace

import numpy as np
import pytest
from synthetic_air import Wake, flown, orbit, wide_jet

from q2q_sim.air.learning.statistics.fitted import Fitted, within_search
from q2q_sim.air.learning.wind_term import wind_term


@pytest.mark.parametrize("value", [0.0, 1e-9, 2.0 - 1e-6, 2.0])
def test_a_value_at_a_bound_of_its_search_has_no_interval(value: float) -> None:
    one = within_search(Fitted("residual.floor_mps2", value, 0.0, 2.0, 9, "rows"), (0.0, 2.0))
    assert one.ends is None
    assert one.source == "rows; at the bound of its search"
    inside = Fitted("residual.floor_mps2", 0.5, 0.3, 0.6, 9, "rows")
    assert within_search(inside, (0.0, 2.0)) == inside


def test_gusts_beyond_the_search_have_no_interval() -> None:
    pair = flown("pair", orbit(60.0, (0.6, 1.05), 1), Wake(wide_jet(), None), 1)
    swell = 5.0 * np.sin(0.3 * pair.motion.t)  # a standard deviation of 3.5, where 3 are searched
    gusty = replace(pair, samples=tuple(replace(one, y=swell) for one in pair.samples))
    found = wind_term([gusty, replace(gusty, name="again")])
    assert found is not None
    std = found.values[0]
    assert std.value == pytest.approx(3.0, abs=0.006)  # what counts as at the bound
    assert std.ends is None
