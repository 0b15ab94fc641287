"""Pairs of vehicles above each other, against a plain loop."""

from itertools import product

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from q2q_control.failsafe.tracking_loss.stacking import stacked_pairs

REACH, GAP = 0.6, 0.1
PLACES = st.sampled_from([0.0, 0.05, 0.1, 0.3, 0.5, 0.7, -0.4, np.nan])


@given(arrays(np.float64, st.tuples(st.integers(0, 6), st.just(3)), elements=PLACES), st.data())
def test_pairs_are_those_of_a_plain_loop(pos: np.ndarray, data: st.DataObject) -> None:
    rows = data.draw(st.lists(st.integers(0, max(len(pos) - 1, 0)), unique=True, max_size=len(pos)))
    expected = [
        (i, j)
        for i, j in product(rows, range(len(pos)))
        if np.hypot(*(pos[j] - pos[i])[:2]) < REACH and pos[j, 2] - pos[i, 2] > GAP
    ]
    assert list(zip(*stacked_pairs(pos, np.array(rows, dtype=np.intp), REACH, GAP), strict=True)) == expected
