"""Commands that end or are missed are reported."""

import numpy as np
from judged_hover import TICKS, T, flown, moved, output


def test_commands_that_end_before_the_flight_are_reported_first_as_they_came_first() -> None:
    status = np.zeros((TICKS, 2))
    status[T > 3.995] = np.nan
    fallen = moved(5.0, 20.0, 0, (0.0, 0.0, 0.0))
    words = "commands ended at 4.0 s of 10.0 s; cf1 hit the floor at 5.0 s; 600 of 1000 ticks were missed"
    assert output(flown(fallen, status=status)) == words


def test_commands_of_one_vehicle_that_end_or_lack_are_not_those_of_another() -> None:
    status = np.zeros((TICKS, 2))
    status[T > 8.495, 1] = np.nan
    words = "cf2's commands ended at 8.5 s of 10.0 s; 150 of 1000 ticks of cf2 were missed"
    assert output(flown(status=status)) == words
    status[:, 1] = np.nan  # flown by somebody else: never commanded here
    assert output(flown(status=status)) == "ok: 10.0 s flown to the end"
    status[100:140, 0] = np.nan
    assert output(flown(status=status)) == "40 of 1000 ticks were missed"


def test_a_hundredth_of_the_ticks_may_be_missed_and_no_more() -> None:
    assert output(flown(), missed=10).startswith("ok")
    assert output(flown(), missed=11) == "11 of 1000 ticks were missed"
    assert output(flown(), missed=999).startswith("999 of 1000")
