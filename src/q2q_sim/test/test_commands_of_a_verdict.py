"""Commands that end, are missed, or fly a vehicle blind are reported."""

import numpy as np
from judged_hover import TICKS, T, flown, moved, output

from q2q_model.signals.values import CommandStatus


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


def test_an_emergency_stop_and_a_blind_landing_are_reported() -> None:
    cut = np.zeros((TICKS, 2))
    cut[T > 6.995] = CommandStatus.CUT
    assert output(flown(status=cut)) == "cf1's motors were cut at 7.0 s; cf2's motors were cut at 7.0 s"
    landing = np.zeros((TICKS, 2))
    landing[(T > 6.995) & (T < 9.495), 1] = CommandStatus.LAND
    assert output(flown(status=landing)).startswith("ok")  # seen again before it was down
    assert output(flown(moved(8.0, 20.0, 1, (0.0, 1.0, 0.0)), status=landing)) == "cf2 landed blind at 8.0 s"


def test_a_vehicle_that_is_flown_blind_to_the_end_is_reported() -> None:
    """Above the floor, where a landing has not ended; level flight after a dropout may still end well."""
    status = np.zeros((TICKS, 2))
    status[T >= 8.995, 1] = CommandStatus.LEVEL
    assert output(flown(status=status)) == "ok: 10.0 s flown to the end"
    status[T >= 9.495, 1] = CommandStatus.LAND
    assert output(flown(status=status)) == "cf2 was flown blind from 9.0 s to the end"
    status[T < 8.995, 1] = CommandStatus.LEVEL
    status[T >= 9.495, 1] = CommandStatus.LEVEL
    assert output(flown(status=status)) == "cf2 was never measured"
    down = moved(3.0, 20.0, 1, (0.0, 1.0, 0.0))
    status[T >= 3.0, 1] = CommandStatus.LAND
    assert output(flown(down, status=status)) == "cf2 was never measured; cf2 landed blind at 3.0 s"
    status[T >= 3.0, 1] = CommandStatus.CUT
    assert output(flown(down, status=status)) == "cf2 was never measured; cf2's motors were cut at 3.0 s"
    status[:, 1] = CommandStatus.CUT
    assert output(flown(status=status)) == "cf2's motors were cut at 0.0 s"
