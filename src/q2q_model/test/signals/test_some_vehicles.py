"""Some vehicles of a signal are their rows of all its columns, in the order asked for."""

import numpy as np
import pytest

from q2q_model.signals.layout import LAYOUTS, Signal
from q2q_model.signals.some_vehicles import of_vehicles
from q2q_model.signals.values import SwarmImu, SwarmSetpoint, SwarmState

VEC, ONE, FLAG = np.arange(9.0).reshape(3, 3), np.arange(3.0), np.arange(3, dtype=np.uint8)
NAMES = ("a", "b", "c")
SIGNALS = (
    SwarmState(1.5, NAMES, VEC, 2 * VEC, np.arange(12.0).reshape(3, 4), 3 * VEC, ONE, FLAG),
    SwarmSetpoint(1.5, NAMES, VEC, 2 * VEC, 3 * VEC, ONE, 2 * ONE, FLAG),
    SwarmImu(1.5, NAMES, VEC, 2 * VEC),
)


@pytest.mark.parametrize("signal", SIGNALS, ids=lambda one: type(one).__name__)
def test_rows_are_taken_of_every_column(signal: Signal) -> None:
    some = of_vehicles(signal, np.array([2, 0]))
    assert (some.t, some.names) == (1.5, ("c", "a"))
    for column in LAYOUTS[type(signal)].columns:
        whole, part = (getattr(one, column.attribute) for one in (signal, some))
        np.testing.assert_array_equal(part, [whole[2], whole[0]])
        assert part.dtype == whole.dtype
