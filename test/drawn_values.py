"""Numbers and names of any kind, drawn for tests."""

import math

from hypothesis import strategies as st

VEHICLES = ("cf1", "cf2")
numbers = st.one_of(
    st.floats(-5.0, 5.0), st.sampled_from([math.nan, math.inf, -math.inf, 1e300, -1e9, 0.0, 5e-324])
)
words = st.one_of(st.sampled_from([*VEHICLES, "cf9", "", "cf1 ", "/", "é" * 50]), st.text(max_size=8))
