"""The verdict names vehicles that were cut, by whom, and those that landed or flew without measurements."""

from dataclasses import replace

import numpy as np
import pytest
from judged_hover import TICKS, T, flown, moved, output

from q2q_model.flights.flight import Flight
from q2q_model.signals.values import CommandStatus

DOWN = (0.0, 1.0, 0.0)
"""Place of cf2 on the floor [m]."""


def test_an_emergency_stop_and_a_landing_without_measurements_are_reported() -> None:
    cut = np.zeros((TICKS, 2))
    cut[T > 6.995] = CommandStatus.CUT
    stopped = "motors were cut by an emergency stop at 7.0 s"
    assert output(flown(status=cut)) == f"cf1's {stopped}; cf2's {stopped}"
    cut[T < 6.995, 1] = CommandStatus.SATURATED
    assert output(flown(status=cut)) == f"cf1's {stopped}; cf2's {stopped}"
    landing = np.zeros((TICKS, 2))
    landing[(T > 6.995) & (T < 9.495), 1] = CommandStatus.LAND
    assert output(flown(status=landing)).startswith("ok")  # seen again before it was down
    assert (
        output(flown(moved(8.0, 20.0, 1, DOWN), status=landing)) == "cf2 landed without measurements at 8.0 s"
    )


def test_a_vehicle_that_is_flown_without_measurements_to_the_end_is_reported() -> None:
    """Above the floor, where a landing has not ended; level flight after a dropout may still end well."""
    status = np.zeros((TICKS, 2))
    status[T >= 8.995, 1] = CommandStatus.LEVEL
    assert output(flown(status=status)) == "ok: 10.0 s flown to the end"
    status[T >= 9.495, 1] = CommandStatus.LAND
    assert output(flown(status=status)) == "cf2 flew without measurements from 9.0 s to the end"
    status[T < 8.995, 1] = CommandStatus.LEVEL
    status[T >= 9.495, 1] = CommandStatus.LEVEL
    assert output(flown(status=status)) == "cf2 was never measured"
    status[T >= 3.0, 1] = CommandStatus.LAND
    assert (
        output(flown(moved(3.0, 20.0, 1, DOWN), status=status))
        == "cf2 was never measured; cf2 landed without measurements at 3.0 s"
    )
    status[T >= 3.0, 1] = CommandStatus.CUT
    assert (
        output(flown(moved(3.0, 20.0, 1, DOWN), status=status))
        == "cf2 was never measured; cf2's motors were cut at 3.0 s"
    )
    status[:, 1] = CommandStatus.CUT
    assert output(flown(status=status)) == "cf2's motors were cut at 0.0 s"


def _with_measured_cf2(flight: Flight, until: float) -> Flight:
    """Return the flight with filtered positions [m], cf2's with 1 mm of noise, held from a time [s]."""
    pos = flight.true_pos.copy()
    pos[until > T, 1, 0] += 1e-3 * np.sin(np.arange((until > T).sum()))
    return replace(flight, pos=pos)


@pytest.mark.parametrize(
    ("lost_at", "how"),
    [(20.0, "on the failsafe's commands, although it was measured,"), (7.0, "without measurements")],
)
def test_a_measured_vehicle_that_the_failsafe_lands_did_not_lack_measurements(
    lost_at: float, how: str
) -> None:
    """A controller that fails is levelled and landed too."""
    status = np.zeros((TICKS, 2))
    status[T >= 6.995, 1] = CommandStatus.LEVEL
    status[T >= 7.995, 1] = CommandStatus.LAND
    said = output(_with_measured_cf2(flown(status=status), lost_at))
    assert said == f"cf2 flew {how} from 7.0 s to the end"
    status[T >= 9.5, 1] = 0.0
    landed = flown(moved(9.0, 20.0, 1, DOWN), status=status)
    assert output(_with_measured_cf2(landed, lost_at)) == f"cf2 landed {how} at 9.0 s"


def test_a_measured_vehicle_whose_controller_always_fails_was_measured() -> None:
    status = np.zeros((TICKS, 2))
    status[:, 1] = CommandStatus.LEVEL
    assert output(_with_measured_cf2(flown(status=status), 2.0)) == "cf2 was never measured"
    status[T >= 1.0, 1] = CommandStatus.LAND
    said = "cf2 flew on the failsafe's commands, although it was measured, from the first command on"
    assert output(_with_measured_cf2(flown(status=status), 20.0)) == said


@pytest.mark.parametrize(
    ("before", "cause"),
    [
        (CommandStatus.SATURATED, " by an emergency stop"),
        (CommandStatus.DEGRADED, " by an emergency stop"),
        (CommandStatus.LEVEL, ""),  # as where land_after_s is cut_after_s
        (CommandStatus.HOLD, ""),  # as where a clock was set ahead by seconds
        (CommandStatus.LAND, ""),
    ],
)
def test_a_cut_that_the_failsafe_cannot_have_made_is_an_emergency_stop(
    before: CommandStatus, cause: str
) -> None:
    status = np.zeros((TICKS, 2))
    status[(T > 6.895) & (T < 6.995), 1] = before
    status[T > 6.995, 1] = CommandStatus.CUT
    assert output(flown(status=status)) == f"cf2's motors were cut{cause} at 7.0 s"


def test_what_the_failsafe_cuts_is_no_emergency_stop() -> None:
    status = np.zeros((TICKS, 2))
    status[(T > 3.995) & (T < 6.995), 1] = CommandStatus.LAND
    status[T > 6.995, 1] = CommandStatus.CUT
    assert output(flown(status=status)) == "cf2's motors were cut at 7.0 s"
    status[(T > 3.995) & (T < 6.995), 1] = np.nan  # a gap in the recording may hide the failsafe
    assert output(flown(status=status)).startswith("cf2's motors were cut at 7.0 s")
