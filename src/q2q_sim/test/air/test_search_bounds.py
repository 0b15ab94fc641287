"""A value at the bound of its search has no interval: the optimum may lie beyond it."""

from dataclasses import replace

import numpy as np
import pytest
from synthetic_air import Wake, flown, orbit, wide_jet

from q2q_sim.air.learning.statistics.fitted import Fitted, within_search
from q2q_sim.air.learning.wind_term import wind_term

FLOOR = Fitted("residual.floor_mps2", 0.5, 0.3, 0.6, 9, "rows")


@pytest.mark.parametrize(
    ("value", "ends", "bounds"),
    [
        (2.0 - 1e-6, (1.8, 2.0), (0.0, 2.0)),
        (2.0, (1.8, 2.0), (0.0, 2.0)),
        (0.01, (0.01, 0.03), (0.01, 10.0)),
        (1.008e-2, (0.01, 0.03), (0.01, 10.0)),  # a fit ends before its bound
        (0.0, (0.0, 1e-5), (0.0, 2.0)),  # not certain to be 0
    ],
)
def test_a_value_at_a_bound_of_its_search_has_no_interval(
    value: float, ends: tuple[float, float], bounds: tuple[float, float]
) -> None:
    one = within_search(replace(FLOOR, value=value, low=ends[0], high=ends[1]), bounds)
    assert one.ends is None
    assert one.source == "rows; at the bound of its search"


@pytest.mark.parametrize(
    ("value", "ends", "bounds"),
    [
        (0.5, (0.3, 0.6), (0.0, 2.0)),
        (0.005, (0.002, 0.008), (0.0, 3.0)),  # small gusts
        (0.0, (0.0, 0.2), (0.0, 2.0)),  # the least that it may be
        (0.02, (0.015, 0.025), (0.01, 10.0)),
    ],
)
def test_a_value_inside_its_search_or_at_zero_keeps_its_interval(
    value: float, ends: tuple[float, float], bounds: tuple[float, float]
) -> None:
    one = replace(FLOOR, value=value, low=ends[0], high=ends[1])
    assert within_search(one, bounds) == one


def test_gusts_beyond_the_search_have_no_interval() -> None:
    pair = flown("pair", orbit(60.0, (0.6, 1.05), 1), Wake(wide_jet(), None), 1)
    swell = 5.0 * np.sin(0.3 * pair.motion.t)  # a standard deviation of 3.5, where 3 are searched
    gusty = replace(pair, samples=tuple(replace(one, y=swell) for one in pair.samples))
    found = wind_term([gusty, replace(gusty, name="again")])
    assert found is not None
    std = found.values[0]
    assert std.value == pytest.approx(3.0, abs=0.006)  # fits end before their bound
    assert std.ends is None
